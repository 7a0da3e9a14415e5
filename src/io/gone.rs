//! Keys and words that configurations once had: who has an old file reads since when one is gone, and what to write instead.

/// One of them.
struct Gone {
    /// How serde refuses it: a key is an unknown field, a word an unknown variant.
    refusal: &'static str,
    /// The key, or the word that a key once took.
    name: &'static str,
    /// A word that the same key takes still, for other keys may take words of the same name; empty for a key.
    beside: &'static str,
    /// The first version without it.
    since: &'static str,
    /// What to write instead.
    instead: &'static str,
}

const fn key(name: &'static str, instead: &'static str) -> Gone {
    Gone { refusal: "unknown field", name, beside: "", since: "0.2.0", instead }
}

const fn handover(name: &'static str) -> Gone {
    Gone { refusal: "unknown variant", name, beside: "`split`", since: "0.2.0", instead: HANDOVER }
}

const GONE: [Gone; 6] = [
    key("colour", "leave it out and give the noise that errs as much over 0.1 s, `--noise 'effective(.1)'`"),
    key("clahe", "leave it out: images are tracked as they are"),
    key("subpixel", "leave it out: corners begin on their pixel"),
    key("repeated", "leave it out: an image that comes twice is passed over"),
    handover("share"),
    handover("drop"),
];

const HANDOVER: &str = "write `handover = \"split\"`, the default: each sighting counts once";

/// What to say where serde refuses a text with `message`, if that is for one of them.
pub(crate) fn gone(message: &str) -> Option<String> {
    let refused = |gone: &&Gone| {
        message.starts_with(&format!("{} `{}`", gone.refusal, gone.name)) && message.contains(gone.beside)
    };
    let found = GONE.iter().find(refused)?;
    Some(format!("`{}` is gone since {}; {}", found.name, found.since, found.instead))
}

#[cfg(test)]
mod tests {
    use super::gone;

    #[test]
    fn a_word_that_is_gone_is_told_from_a_key_and_from_another_keys_word() {
        let said = gone("unknown variant `share`, expected one of `reuse`, `split`, `consume`").unwrap();
        assert!(said.starts_with("`share` is gone since 0.2.0; write `handover"), "{said}");
        assert_eq!(gone("unknown field `share`, expected one of `rotors`, `hz`"), None);
        assert_eq!(gone("unknown variant `drop`, expected `keep`"), None);
        assert!(gone("unknown field `clahe`, expected one of `klt`, `ransac`").is_some());
    }
}
