//! Typed TOML configuration: unknown keys are refused with the nearest known one, bad values all at once.

use crate::printable;
use crate::small::{LARGEST_CONFIG, bounded};
use dpn_core::config::{ConfigFaults, Validate, did_you_mean, gone, nearest};
use serde::de::DeserializeOwned;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Why a configuration is not used.
#[derive(Debug, Error)]
pub enum ConfigError {
    /// The file cannot be read.
    #[error("cannot read {}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Not TOML, a key that is not known, or a value of the wrong kind.
    #[error("{}{}: {message}", path.display(), line.map(|l| format!(":{l}")).unwrap_or_default())]
    Parse {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: Option<usize>,
        /// What is wrong.
        message: String,
        /// The nearest known word, where one is near.
        nearest: Option<String>,
    },
    /// Values outside their bounds.
    #[error("{}: {faults}", path.display())]
    Bounds {
        /// The file.
        path: PathBuf,
        /// Every fault.
        faults: ConfigFaults,
    },
}

impl ConfigError {
    /// What to do about it.
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::Read { .. } => Some("configs/ holds files to start from".into()),
            Self::Parse { nearest: Some(nearest), .. } => Some(did_you_mean(nearest)),
            _ => None,
        }
    }
}

/// The text of the configuration at `path`, for who parses it in another way than [`load`]; nobody writes one of megabytes.
///
/// # Errors
/// A file that cannot be read, is no UTF-8 or is larger than any configuration.
pub fn text_of(path: &Path) -> Result<String, ConfigError> {
    let failed = |source| ConfigError::Read { path: path.to_owned(), source };
    let invalid = |words: String| failed(io::Error::new(io::ErrorKind::InvalidData, words));
    let file = std::fs::File::open(path).map_err(failed)?;
    let too_large = || invalid(format!("more than {LARGEST_CONFIG} bytes; no configuration is as large"));
    let bytes = bounded(file).map_err(failed)?.ok_or_else(too_large)?;
    String::from_utf8(bytes).map_err(|_| invalid("stream did not contain valid UTF-8".to_owned()))
}

/// Reads, parses and checks the configuration at `path`.
///
/// # Errors
/// An unreadable file, a text that is not the configuration's TOML, values outside their bounds.
pub fn load<T: DeserializeOwned + Validate>(path: &Path) -> Result<T, ConfigError> {
    parse(&text_of(path)?, path)
}

/// Parses and checks `text`; `path` only names it in errors.
///
/// # Errors
/// A text that is not the configuration's TOML, values outside their bounds.
pub fn parse<T: DeserializeOwned + Validate>(text: &str, path: &Path) -> Result<T, ConfigError> {
    let config: T = toml::from_str(text).map_err(|error| {
        let line = error.span().map(|span| text[..span.start.min(text.len())].matches('\n').count());
        let message = with_key(printable(error.message()), line.and_then(|line| text.lines().nth(line)));
        refused(path.to_owned(), line.map(|line| line + 1), message)
    })?;
    match config.validate() {
        Ok(()) => Ok(config),
        Err(faults) => Err(ConfigError::Bounds { path: path.to_owned(), faults }),
    }
}

/// As [`load`], or the defaults without a file, with single keys set over it: `("window.key_frames", "8")`, the value as TOML writes it.
///
/// # Errors
/// As [`load`]; a key that is not known, a value of the wrong kind.
pub fn load_over<T: DeserializeOwned + Validate>(
    path: Option<&Path>,
    sets: &[(String, String)],
) -> Result<T, ConfigError> {
    of_table(table_over::<T>(path, sets)?, path, sets)
}

/// The keys of a file, or none without one, with single keys set over them, each known to `T`: for who has defaults of its own to lay them over.
///
/// # Errors
/// As [`load_over`].
pub fn table_over<T: DeserializeOwned + Validate>(
    path: Option<&Path>,
    sets: &[(String, String)],
) -> Result<toml::Table, ConfigError> {
    let text = path.map(text_of).transpose()?.unwrap_or_default();
    let name = named(path, &[]);
    // Its errors alone can name lines.
    parse::<T>(&text, &name)?;
    let mut table: toml::Table =
        toml::from_str(&text).map_err(|e| refused(name, None, e.message().to_owned()))?;
    for (key, text) in sets {
        let wrong = |message: String| refused(PathBuf::from(format!("{key}={text}")), None, message);
        put(&mut table, key, value_of(text)).map_err(wrong)?;
        // Key by key, so that the message names the one that is wrong.
        if let Err(error) = table.clone().try_into::<T>() {
            // Where one of several words is expected, the message lists them only to who wrote a word, without its quotes.
            let word = toml::Value::String(text.trim_matches(['"', '\'']).to_owned());
            put(&mut table, key, word).map_err(wrong)?;
            let as_word = table.try_into::<T>().err().filter(|e| e.message().starts_with("unknown variant"));
            return Err(wrong(as_word.unwrap_or(error).message().to_owned()));
        }
    }
    Ok(table)
}

/// The checked configuration of a table that was made of `path` and `sets`, which errors name.
///
/// # Errors
/// A key that is not known, a value of the wrong kind or outside its bounds.
pub fn of_table<T: DeserializeOwned + Validate>(
    table: toml::Table,
    path: Option<&Path>,
    sets: &[(String, String)],
) -> Result<T, ConfigError> {
    let config: T = table
        .try_into()
        .map_err(|e: toml::de::Error| refused(named(path, sets), None, e.message().to_owned()))?;
    match config.validate() {
        Ok(()) => Ok(config),
        Err(faults) => Err(ConfigError::Bounds { path: named(path, sets), faults }),
    }
}

/// What errors call it: without its single keys a file is within its bounds.
fn named(path: Option<&Path>, sets: &[(String, String)]) -> PathBuf {
    if sets.is_empty() {
        return path.unwrap_or(Path::new("the built-in defaults")).to_owned();
    }
    sets.iter().map(|(key, text)| format!("{key}={text}")).collect::<Vec<_>>().join(", ").into()
}

/// What was written after `=`: a TOML value; else a number as people write it (`.5`), else a word, as `window.loss=huber` means it.
fn value_of(text: &str) -> toml::Value {
    let parsed = toml::from_str::<toml::Table>(&format!("value = {text}"));
    let number = || text.parse().ok().map(toml::Value::Float);
    parsed
        .ok()
        .and_then(|mut table| table.remove("value"))
        .or_else(number)
        .unwrap_or_else(|| toml::Value::String(text.to_owned()))
}

/// Puts `value` at `key`, dots of which go into tables.
fn put(table: &mut toml::Table, key: &str, value: toml::Value) -> Result<(), String> {
    match key.split_once('.') {
        Some((head, rest)) => {
            let inner = table.entry(head).or_insert_with(|| toml::Value::Table(toml::Table::new()));
            let inner = inner.as_table_mut().ok_or_else(|| format!("`{head}` is no table"))?;
            put(inner, rest, value)
        }
        None => {
            table.insert(key.to_owned(), value);
            Ok(())
        }
    }
}

/// A message on a value, which says nothing of its key, with the key that its line begins with.
fn with_key(message: String, line: Option<&str>) -> String {
    let key = line.and_then(|line| line.split_once('=')).map(|(key, _)| key.trim());
    match key.filter(|_| message.starts_with("invalid ")) {
        Some(key) => format!("`{key}`: {message}"),
        None => message,
    }
}

/// A text that serde refuses with `message`: a key that was there once is named as such, another has the nearest known one beside it.
fn refused(path: PathBuf, line: Option<usize>, message: String) -> ConfigError {
    match gone(&message) {
        Some(message) => ConfigError::Parse { path, line, message, nearest: None },
        None => ConfigError::Parse { path, line, nearest: nearest_word(&message), message },
    }
}

/// From serde's "unknown field `a`, expected one of `b`, `c`": the expected word nearest to the unknown one.
fn nearest_word(message: &str) -> Option<String> {
    let mut quoted = message.split('`').skip(1).step_by(2);
    let typed = quoted.next()?;
    nearest(typed, quoted).map(str::to_owned)
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::config::ConfigFault;
    use serde::Deserialize;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields, default)]
    struct Small {
        learning_rate: f64,
        epochs: u64,
    }

    impl Default for Small {
        fn default() -> Self {
            Self { learning_rate: 1e-3, epochs: 200 }
        }
    }

    impl Validate for Small {
        fn faults(&self) -> Vec<ConfigFault> {
            let mut faults = ConfigFaults::default();
            let rate = self.learning_rate;
            faults.check(rate > 0.0, "learning_rate", rate, "above 0");
            faults.within("epochs", self.epochs, 1, 1000);
            faults.0
        }
    }

    fn parsed(text: &str) -> Result<Small, ConfigError> {
        parse(text, Path::new("a.toml"))
    }

    #[test]
    fn an_unknown_key_names_line_and_nearest() {
        let error = parsed("epochs = 3\nlerning_rate = 0.1\n").unwrap_err();
        assert!(error.to_string().starts_with("a.toml:2: unknown field `lerning_rate`"), "{error}");
        assert_eq!(error.hint().as_deref(), Some("did you mean `learning_rate`?"));
    }

    #[test]
    fn a_value_of_another_type_is_refused_by_its_key() {
        let error = parsed("learning_rate = 0.1\nepochs = [\n3]").unwrap_err().to_string();
        assert_eq!(error, "a.toml:2: `epochs`: invalid type: sequence, expected u64");
    }

    #[test]
    fn a_key_that_is_gone_is_named_with_since_when_and_what_to_write_instead() {
        let error = parsed("epochs = 3\nclahe = { enabled = true }").unwrap_err();
        let words = "a.toml:2: `clahe` is gone since 0.2.0; leave it out: images are tracked as they are";
        assert_eq!((error.to_string().as_str(), error.hint()), (words, None));
        let set = [("subpixel".to_owned(), "4".to_owned())];
        let error = load_over::<Small>(None, &set).unwrap_err().to_string();
        assert!(error.starts_with("subpixel=4: `subpixel` is gone since 0.2.0; "), "{error}");
    }

    #[test]
    fn what_is_set_on_the_command_line_is_a_value_a_number_or_a_word() {
        let set = |key: &str, text: &str| {
            load_over::<Small>(None, &[(key.to_owned(), text.to_owned())])
                .map(|c| (c.learning_rate, c.epochs))
        };
        assert_eq!(set("learning_rate", ".5").unwrap(), (0.5, 200));
        assert_eq!(set("learning_rate", "5e-4").unwrap(), (5e-4, 200));
        assert_eq!(set("epochs", "3").unwrap(), (1e-3, 3));
        let error = set("epochs", "many").unwrap_err().to_string();
        assert!(error.starts_with("epochs=many: invalid type: string \"many\""), "{error}");
        let error = set("epochs", "0").unwrap_err().to_string();
        assert_eq!(error, "epochs=0: `epochs` is 0, but must be 1 to 1000");
    }

    #[test]
    fn all_bad_values_are_named_at_once() {
        let error = parsed("epochs = 0\nlearning_rate = -1.0").unwrap_err().to_string();
        assert!(
            error
                .contains("`learning_rate` is -1, but must be above 0; `epochs` is 0, but must be 1 to 1000"),
            "{error}"
        );
    }
}
