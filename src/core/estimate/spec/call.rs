//! The grammar of noise specs: calls of a name with arguments, separated by commas.
//!
//! ```text
//! spec  = call { "," call }
//! call  = word [ "(" [ arg { "," arg } ] ")" ]
//! arg   = number | '"' any but '"' '"' | call
//! word  = characters other than blanks, commas, brackets and quotes
//! ```
//! Blanks between parts are skipped. An argument in quotes may hold anything: `track("a, b.csv")`.

use super::SpecError;
use std::fmt;

/// A name and what stands in its brackets.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Call {
    /// The word before the bracket.
    pub(crate) name: String,
    /// The arguments; empty without brackets.
    pub(crate) args: Vec<Arg>,
}

/// One argument.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Arg {
    /// A finite number.
    Number(f64),
    /// A text in quotes.
    Text(String),
    /// A call, or a bare word: a call without arguments.
    Call(Call),
}

impl Call {
    /// Reads every call of `spec`.
    ///
    /// # Errors
    /// A broken grammar: an empty spec or argument, a bracket or quote left open, something behind the end.
    pub(crate) fn parse_list(spec: &str) -> Result<Vec<Self>, SpecError> {
        let mut reader = Reader { spec, chars: spec.chars().collect(), at: 0, depth: 0 };
        let mut calls = vec![reader.call()?];
        while reader.take(',') {
            calls.push(reader.call()?);
        }
        reader.skip_blanks();
        if reader.at < reader.chars.len() {
            return Err(reader.error("a comma or the end"));
        }
        Ok(calls)
    }
}

impl fmt::Display for Call {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.name)?;
        for (i, arg) in self.args.iter().enumerate() {
            f.write_str(if i == 0 { "(" } else { "," })?;
            match arg {
                Arg::Number(number) => write!(f, "{number}")?,
                Arg::Text(text) => write!(f, "\"{text}\"")?,
                Arg::Call(call) => write!(f, "{call}")?,
            }
        }
        if self.args.is_empty() { Ok(()) } else { f.write_str(")") }
    }
}

/// Brackets within brackets deeper than this are no spec.
const DEEPEST: usize = 32;

struct Reader<'a> {
    spec: &'a str,
    chars: Vec<char>,
    at: usize,
    depth: usize,
}

impl Reader<'_> {
    fn error(&self, expected: &'static str) -> SpecError {
        SpecError::Syntax { spec: self.spec.to_owned(), at: self.at, expected }
    }

    fn skip_blanks(&mut self) {
        while self.chars.get(self.at).is_some_and(|c| c.is_whitespace()) {
            self.at += 1;
        }
    }

    fn take(&mut self, wanted: char) -> bool {
        self.skip_blanks();
        let found = self.chars.get(self.at) == Some(&wanted);
        self.at += usize::from(found);
        found
    }

    fn word(&mut self) -> String {
        self.skip_blanks();
        let from = self.at;
        let inside = |c: &char| !c.is_whitespace() && !",()\"".contains(*c);
        while self.chars.get(self.at).is_some_and(inside) {
            self.at += 1;
        }
        self.chars[from..self.at].iter().collect()
    }

    fn call(&mut self) -> Result<Call, SpecError> {
        let name = self.word();
        if name.is_empty() {
            return Err(self.error("a name"));
        }
        self.call_of(name)
    }

    fn call_of(&mut self, name: String) -> Result<Call, SpecError> {
        let mut args = Vec::new();
        if self.take('(') {
            self.depth += 1;
            if self.depth > DEEPEST {
                return Err(self.error("fewer brackets within brackets"));
            }
            if !self.take(')') {
                args.push(self.arg()?);
                while self.take(',') {
                    args.push(self.arg()?);
                }
                if !self.take(')') {
                    return Err(self.error("a comma or `)`"));
                }
            }
            self.depth -= 1;
        }
        Ok(Call { name, args })
    }

    fn arg(&mut self) -> Result<Arg, SpecError> {
        if self.take('"') {
            let from = self.at;
            while self.chars.get(self.at).is_some_and(|c| *c != '"') {
                self.at += 1;
            }
            let text = self.chars[from..self.at].iter().collect();
            return if self.take('"') { Ok(Arg::Text(text)) } else { Err(self.error("a closing quote")) };
        }
        let word = self.word();
        if word.is_empty() {
            return Err(self.error("an argument"));
        }
        match word.parse::<f64>() {
            Ok(number) if number.is_finite() => Ok(Arg::Number(number)),
            _ => Ok(Arg::Call(self.call_of(word)?)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn nested_calls_numbers_and_quoted_texts_are_read() {
        let calls = Call::parse_list(r#" shuffled( sg(11, 2), 3 ) , track("a, (b).csv",-1.5e-3) "#).unwrap();
        assert_eq!(calls.len(), 2);
        assert_eq!(calls[0].to_string(), "shuffled(sg(11,2),3)");
        assert_eq!(calls[1].args, [Arg::Text("a, (b).csv".into()), Arg::Number(-0.0015)]);
    }

    #[test]
    fn broken_specs_name_the_place() {
        for (spec, place, expected) in [
            ("", 0, "a name"),
            ("sg(11,2", 7, "a comma or `)`"),
            ("sg(11,)", 6, "an argument"),
            ("x1,,x2", 3, "a name"),
            ("x1)", 2, "a comma or the end"),
            ("f(\"a", 4, "a closing quote"),
        ] {
            let error = Call::parse_list(spec).unwrap_err();
            let SpecError::Syntax { at, expected: got, .. } = error else { panic!("{error}") };
            assert_eq!((at, got), (place, expected), "{spec}");
        }
        assert!(Call::parse_list(&"f(".repeat(100_000)).is_err());
    }

    proptest! {
        #[test]
        fn any_text_is_read_or_refused_and_what_is_read_survives_writing(spec in "[a-z0-9.,() \"-]{0,30}") {
            if let Ok(calls) = Call::parse_list(&spec) {
                let text: Vec<String> = calls.iter().map(Call::to_string).collect();
                prop_assert_eq!(Call::parse_list(&text.join(",")).unwrap(), calls);
            }
        }
    }
}
