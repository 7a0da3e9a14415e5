//! Keys that configurations once had, each with the one value it was ever given: files hold them still, so that the same weights are the same
//! bytes, and the program knows them no more.

use serde_json::{Map, Value, json};

/// Every retired key and its value.
fn retired() -> [(&'static str, Value); 4] {
    [
        ("edges", json!("zero")),
        ("rescale_output", json!(false)),
        ("standardise", json!("none")),
        ("symmetrise", json!(false)),
    ]
}

/// Writes them into the network's configuration in a description, and into that of the training beside it.
pub(crate) fn put(description: &mut Value) {
    each(description, |config| {
        config.extend(retired().map(|(key, value)| (key.to_owned(), value)));
    });
}

/// Takes them out again; a value that this program cannot compute stays, and is refused as the unknown key it is.
pub(crate) fn take(description: &mut Value) {
    each(description, |config| {
        for (key, value) in retired() {
            if config.get(key) == Some(&value) {
                config.remove(key);
            }
        }
    });
}

fn each(description: &mut Value, change: impl Fn(&mut Map<String, Value>)) {
    for place in ["/config", "/card/training/run/network", "/notes/run/config/network"] {
        if let Some(Value::Object(config)) = description.pointer_mut(place) {
            change(config);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::ProNetConfig;

    #[test]
    fn what_is_put_is_taken_and_another_value_stays_to_be_refused() {
        let config = json!({ "config": ProNetConfig::default() });
        let mut stored = config.clone();
        put(&mut stored);
        assert_eq!(stored["config"]["edges"], "zero");
        let mut read = stored.clone();
        take(&mut read);
        assert_eq!(read, config);
        stored["config"]["edges"] = json!("odd");
        take(&mut stored);
        let error = serde_json::from_value::<ProNetConfig>(stored["config"].take()).unwrap_err();
        assert!(error.to_string().contains("`edges`"), "{error}");
    }
}
