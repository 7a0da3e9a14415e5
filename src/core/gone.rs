//! Keys and words that configurations and the headers of weights once had: who has an old file reads since when one is gone, and what to write instead.

/// One of them.
struct Gone {
    /// How serde refuses it: a key is an unknown field, a word an unknown variant.
    refusal: &'static str,
    /// The key, or the word that a key once took.
    name: &'static str,
    /// A key of the same table, or a word that the same key takes still: elsewhere another may have the name. Empty where no other has.
    beside: &'static str,
    /// The first version without it.
    since: &'static str,
    /// What to write instead.
    instead: &'static str,
}

const fn key(name: &'static str, instead: &'static str) -> Gone {
    Gone { refusal: "unknown field", name, beside: "", since: "0.2.0", instead }
}

const fn word(name: &'static str, beside: &'static str, instead: &'static str) -> Gone {
    Gone { refusal: "unknown variant", name, beside, since: "0.2.0", instead }
}

/// A key that every network's configuration had, with one and the same value.
const fn header(name: &'static str) -> Gone {
    Gone { beside: "`norm_axes`", ..key(name, HEADER) }
}

/// A key of a paper's sweep.
const fn of_paper(name: &'static str) -> Gone {
    Gone { beside: "`quick`", ..key(name, "write it in the table [run]") }
}

const GONE: [Gone; 25] = [
    key("colour", "leave it out and give the noise that errs as much over 0.1 s, `--noise 'effective(.1)'`"),
    key("clahe", "leave it out: images are tracked as they are"),
    key("subpixel", "leave it out: corners begin on their pixel"),
    key("illumination", "leave it out: every patch has a gain and an offset of its own"),
    key("repeated", "leave it out: an image that comes twice is passed over"),
    word("share", "`split`", HANDOVER),
    word("drop", "`split`", HANDOVER),
    Gone { beside: "`filter`", ..key("scope", "leave it out: every window is filtered on its own") },
    Gone { beside: "`levels`", ..key("draws", "leave it out: noise is drawn anew every epoch") },
    word("channels-and-time", "`channels`", "write `norm_axes = \"channels\"`, the default"),
    word(
        "linear",
        "`softplus`",
        "write `head = \"leaky-relu\"`, the paper's, or `\"softplus\"`, the default",
    ),
    word("differences", "`second-differences`", "write `input = \"second-differences\"`"),
    header("edges"),
    header("rescale_output"),
    header("standardise"),
    header("symmetrise"),
    of_paper("data"),
    of_paper("models"),
    of_paper("tracks"),
    of_paper("sequences"),
    of_paper("from"),
    of_paper("estimator"),
    of_paper("simulated_tracks"),
    of_paper("images"),
    of_paper("flights"),
];

const HEADER: &str = "train again, or take such keys out of the file by `python models/gone_keys.py FILE`";

const HANDOVER: &str = "write `handover = \"split\"`, the default: each sighting counts once";

/// Settings of the odometry and of simulated flights that are fixed since 0.2.0, each with a key that its table has still: other tables may have keys of the same name.
const FIXED: [(&str, &str); 7] = [
    ("`front_end`", "jumps"),
    ("`learn`", "prior_px"),
    ("`corners`", "bridge_s gap_s blind_share blind_std"),
    ("`threshold_px`", "geometry confidence most_trials doubt_share"),
    ("`focal_px`", FIXED_INIT),
    (
        "`hover_hz`",
        "idle_speed spin_up_s speed_wander_s amplitude_wander_s low_line_hz low_line_wander_hz accel gyro",
    ),
    ("`accel_walk`", "accel_start gyro_start"),
];

const FIXED_INIT: &str = "track_std_px min_span_s try_every min_shared_tracks min_parallax_px min_accel_noise min_gyro_noise noise_prior_weight rest_track_px min_rest_s";

/// What to say where serde refuses a text with `message`, if that is for one of them.
pub fn gone(message: &str) -> Option<String> {
    let refused = |gone: &Gone| {
        message.starts_with(&format!("{} `{}`", gone.refusal, gone.name)) && message.contains(gone.beside)
    };
    let fixed = FIXED.into_iter().filter(|(beside, _)| message.contains(beside));
    let fixed = fixed
        .flat_map(|(_, names)| names.split(' '))
        .map(|name| key(name, "leave it out: its value is fixed"));
    let found = GONE.into_iter().chain(fixed).find(refused)?;
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
        assert!(gone("unknown field `min_rest_s`, expected one of `focal_px`, `max_frames`").is_some());
        assert_eq!(gone("unknown field `confidence`, expected one of `level`, `seed`"), None);
    }
}
