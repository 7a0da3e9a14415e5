//! Names out of other people's files, as they may be shown.
//!
//! A topic, a column or a key of a configuration may hold anything, escape sequences for a terminal too. The readers take such names through
//! [`printable`] where they come in, so that no message, table or picture behind them holds a control character, and what is shown can be typed.

/// `text` with control characters, and those that turn the direction of writing, spelt out: `\u{1b}[2J`.
pub fn printable(text: &str) -> String {
    let is_harmful = |c: char| {
        c.is_control()
            || matches!(c, '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
    };
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if is_harmful(c) { out.extend(c.escape_unicode()) } else { out.push(c) }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_steers_a_terminal_is_spelt_out_and_what_people_write_is_as_it_was() {
        assert_eq!(printable("/imu\u{1b}[2J\u{7}\u{9b}\n"), "/imu\\u{1b}[2J\\u{7}\\u{9b}\\u{a}");
        assert_eq!(printable("a\u{202e}b"), "a\\u{202e}b");
        for name in ["/imu0", "Drehrate °/s", "角速度.x", "a\\u{1b}"] {
            assert_eq!(printable(name), name);
        }
    }
}
