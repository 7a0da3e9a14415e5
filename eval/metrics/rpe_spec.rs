//! Which stretches a relative pose error is over, in the words of `evo_rpe`'s flags.
//!
//! | here | `evo_rpe` |
//! |---|---|
//! | `1m` | `--delta 1 --delta_unit m`: each stretch begins where the one before ended, and ends at the first pose that is as far |
//! | `1m:all_pairs` | `--delta 1 --delta_unit m --all_pairs`: one from every pose, to the pose whose distance is nearest |
//! | `1m:pairs_from_reference` | `--pairs_from_reference`: metres along the true path instead of the estimate's |
//!
//! Units are `m`, `f` (frames), `deg` and `s`; evo has no seconds.

use super::associate::PosePair;
use nalgebra::Isometry3;
use std::fmt;
use std::str::FromStr;
use thiserror::Error;

/// Length of a stretch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum RpeStep {
    /// Metres along the path.
    Metres(f64),
    /// Seconds.
    Seconds(f64),
    /// Poses.
    Frames(usize),
    /// Degrees turned: between its ends where stretches begin everywhere, else along the way.
    Degrees(f64),
}

impl RpeStep {
    /// The usual ones: 5, 10, 20 and 40 m, 1 and 5 s.
    pub const USUAL: [Self; 6] = [
        Self::Metres(5.0),
        Self::Metres(10.0),
        Self::Metres(20.0),
        Self::Metres(40.0),
        Self::Seconds(1.0),
        Self::Seconds(5.0),
    ];
}

/// Stretches by name.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RpeSpec {
    /// How long they are.
    pub step: RpeStep,
    /// Whether one begins at every pose, instead of where the one before ended.
    pub all_pairs: bool,
    /// Along which trajectory they are measured.
    pub on: StretchesOn,
}

/// Along which trajectory stretches are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StretchesOn {
    /// The estimate; evo unless told otherwise.
    Estimate,
    /// The truth.
    Reference,
}

impl StretchesOn {
    /// The pose of that trajectory.
    pub(super) fn pose(self, pair: &PosePair) -> &Isometry3<f64> {
        match self {
            Self::Estimate => &pair.est_world_from_body,
            Self::Reference => &pair.true_world_from_body,
        }
    }
}

impl RpeSpec {
    /// The step as a number in its unit.
    pub(super) fn length(&self) -> f64 {
        match self.step {
            RpeStep::Metres(v) | RpeStep::Seconds(v) | RpeStep::Degrees(v) => v,
            RpeStep::Frames(n) => n as f64,
        }
    }
}

const ALL_PAIRS: &str = "all_pairs";
const FROM_REFERENCE: &str = "pairs_from_reference";

/// What is no [`RpeSpec`].
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error(
    "`{text}` names no stretches: {what}; known are a length in m, f (frames), deg or s, then :all_pairs and :pairs_from_reference, \
     for example 1m, 10f:all_pairs"
)]
pub struct BadRpeSpec {
    /// As it was given.
    pub text: String,
    /// What is wrong with it.
    pub what: String,
}

impl FromStr for RpeSpec {
    type Err = BadRpeSpec;

    fn from_str(text: &str) -> Result<Self, BadRpeSpec> {
        let bad = |what: String| BadRpeSpec { text: text.to_owned(), what };
        let mut words = text.split(':');
        let length = words.next().expect("a split text has a first part").trim();
        let at = length.find(|c: char| c.is_ascii_alphabetic() && c != 'e').unwrap_or(length.len());
        let (number, unit) = length.split_at(at);
        let positive = |v: &f64| v.is_finite() && *v > 0.0;
        let value = number.trim().parse::<f64>().ok().filter(positive);
        let value = value.ok_or_else(|| bad(format!("`{number}` is no number above 0")))?;
        let step = match unit {
            "m" => RpeStep::Metres(value),
            "s" => RpeStep::Seconds(value),
            "deg" if value < 180.0 => RpeStep::Degrees(value),
            "deg" => return Err(bad("nothing turns by 180 degrees or more".to_owned())),
            "f" if value.fract() == 0.0 => RpeStep::Frames(value as usize),
            "f" => return Err(bad("frames are counted whole".to_owned())),
            _ => return Err(bad(format!("`{unit}` is no unit"))),
        };
        let mut spec = Self { step, all_pairs: false, on: StretchesOn::Estimate };
        for word in words {
            match word.trim() {
                ALL_PAIRS => spec.all_pairs = true,
                FROM_REFERENCE => spec.on = StretchesOn::Reference,
                other => return Err(bad(format!("`{other}` is not known"))),
            }
        }
        Ok(spec)
    }
}

impl fmt::Display for RpeSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.step {
            RpeStep::Metres(v) => write!(f, "{v}m")?,
            RpeStep::Seconds(v) => write!(f, "{v}s")?,
            RpeStep::Frames(n) => write!(f, "{n}f")?,
            RpeStep::Degrees(v) => write!(f, "{v}deg")?,
        }
        if self.all_pairs {
            write!(f, ":{ALL_PAIRS}")?;
        }
        match self.on {
            StretchesOn::Estimate => Ok(()),
            StretchesOn::Reference => write!(f, ":{FROM_REFERENCE}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_is_written_as_it_is_read() {
        for text in
            ["1m", "0.5s:all_pairs", "10f:all_pairs:pairs_from_reference", "30deg:pairs_from_reference"]
        {
            assert_eq!(text.parse::<RpeSpec>().unwrap().to_string(), text);
        }
        assert_eq!(" 1e1 m".parse::<RpeSpec>().unwrap().step, RpeStep::Metres(10.0));
    }

    #[test]
    fn what_names_no_stretches_is_refused_with_its_fault() {
        let what = |text: &str| text.parse::<RpeSpec>().unwrap_err().what;
        assert_eq!(what("m"), "`` is no number above 0");
        assert_eq!(what("-1m"), "`-1` is no number above 0");
        assert_eq!(what("inf"), "`` is no number above 0");
        assert_eq!(what("1"), "`` is no unit");
        assert_eq!(what("1.5f"), "frames are counted whole");
        assert_eq!(what("180deg"), "nothing turns by 180 degrees or more");
        assert_eq!(what("1m:every"), "`every` is not known");
    }
}
