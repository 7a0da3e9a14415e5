//! Keys and words that configurations once had: who has an old file reads since when one is gone, and what to write instead.

/// One of them.
struct Gone {
    /// The key, or the word that a key once took.
    name: &'static str,
    /// The first version without it.
    since: &'static str,
    /// What to write instead.
    instead: &'static str,
}

const GONE: [Gone; 6] = [
    Gone {
        name: "colour",
        since: "0.2.0",
        instead: "leave it out and give the noise that errs as much over 0.1 s, `--noise 'effective(.1)'`",
    },
    Gone { name: "clahe", since: "0.2.0", instead: "leave it out: images are tracked as they are" },
    Gone { name: "subpixel", since: "0.2.0", instead: "leave it out: corners begin on their pixel" },
    Gone { name: "share", since: "0.2.0", instead: HANDOVER },
    Gone { name: "drop", since: "0.2.0", instead: HANDOVER },
    Gone {
        name: "repeated",
        since: "0.2.0",
        instead: "leave it out: an image that comes twice is passed over",
    },
];

const HANDOVER: &str = "write `handover = \"split\"`, the default: each sighting counts once";

/// What to say of `name`, where it is one of them.
pub(crate) fn gone(name: &str) -> Option<String> {
    let found = GONE.iter().find(|gone| gone.name == name)?;
    Some(format!("`{name}` is gone since {}; {}", found.since, found.instead))
}
