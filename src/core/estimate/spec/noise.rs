//! Everything that may be written for the noise: what this crate makes, and what needs networks, files or other recordings.
//!
//! | spec | the noise of a sample |
//! |---|---|
//! | `dualpronet`, `dualpronet(TAG)`, `dualpronet(ACCEL,GYRO)` | what the networks say; tags are names of weight files, `sg5-s0` |
//! | `file("PATH")` | what a noise track on disk says; it must cover the IMU's samples |
//! | `oracle` | the deviation it was drawn with; simulated flights only |
//! | `shuffled(X)` | X's values, permuted in time in blocks of 1 s: the same values, not at their time |
//! | `mean(X)` | X's root mean square over the sequence, per axis: the same level, no change in time |
//! | `mean-of-train(X)` | X's root mean square over the training sequences, per axis: nothing of this sequence |
//! | `self`, `self(X)` | X's (x1 where none is said) times levels that the odometry learns while it runs, by axis |
//! | `mean(self)`, `shuffled(self)` | made of the samples' noise in force in a first run; walks and pixels are as told |
//! | `plus(X,C)` | root of the sum of squares of X's and a constant's: X for what was added, C for what is there in any case |
//!
//! Specs nest: `shuffled(dualpronet)`, `mean(x4,x1)`. `shuffled`, `mean` and `mean-of-train` are controls: they tell what of a gain is due to
//! knowing *when*, what to knowing *how much in this flight*, and what to a good constant.

use super::{Arg, Call, SensorPair, SensorSpec, SpecError, names};
use serde::{Deserialize, Serialize};
use std::fmt;
use std::path::PathBuf;
use std::str::FromStr;

/// The shipped networks that `dualpronet` alone stands for.
pub const DEFAULT_TAG: &str = "sg11-s0";
/// The shipped networks for raw flights, vibration and all.
pub const FLIGHT_TAG: &str = "flight-s0";

/// Where the noise of every sample comes from. `FromStr` reads it, `Display` writes it canonically.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub enum NoiseSpec {
    /// Constants and simple estimators.
    Sensors(SensorPair),
    /// The networks: names of the weight files of accelerometer and gyroscope.
    DualProNet {
        /// The accelerometer's.
        accel: String,
        /// The gyroscope's.
        gyro: String,
    },
    /// A noise track on disk.
    File(PathBuf),
    /// The truth of a simulated flight.
    Oracle,
    /// Another's values at other times.
    Shuffled(Box<NoiseSpec>),
    /// Another's root mean square over the sequence.
    Mean(Box<NoiseSpec>),
    /// Another's root mean square over the training sequences.
    MeanOfTrain(Box<NoiseSpec>),
    /// Another's times levels that the odometry learns while it runs.
    Learned(Box<NoiseSpec>),
    /// Another's and a constant's, variances added.
    Plus {
        /// What changes.
        of: Box<NoiseSpec>,
        /// What is there in any case.
        constant: SensorPair,
    },
}

impl NoiseSpec {
    /// The spec that this one is made of, where it is made of one.
    fn made_of(&self) -> Option<&Self> {
        match self {
            Self::Shuffled(of)
            | Self::Mean(of)
            | Self::MeanOfTrain(of)
            | Self::Learned(of)
            | Self::Plus { of, .. } => Some(of),
            Self::Sensors(_) | Self::DualProNet { .. } | Self::File(_) | Self::Oracle => None,
        }
    }

    /// The spec whose track this one needs: itself, or what the controls are made of.
    pub fn source(&self) -> &Self {
        self.made_of().map_or(self, Self::source)
    }

    /// Whether the training sequences are needed.
    pub fn needs_training(&self) -> bool {
        matches!(self, Self::MeanOfTrain(_)) || self.made_of().is_some_and(Self::needs_training)
    }

    /// Whether the odometry learns levels while it runs.
    pub fn is_learned(&self) -> bool {
        matches!(self, Self::Learned(_))
    }

    /// The learned noise that a first run of the odometry has to learn before this one can be told: that of a control.
    pub fn learned_before(&self) -> Option<&Self> {
        let of = self.made_of()?;
        if of.is_learned() { Some(of) } else { of.learned_before() }
    }

    /// The factor on the baseline of both sensors, where that is what the spec says.
    pub fn multiple(&self) -> Option<f64> {
        match self {
            Self::Sensors(SensorPair { accel: SensorSpec::Multiple(accel), gyro }) => {
                (*gyro == SensorSpec::Multiple(*accel)).then_some(*accel)
            }
            _ => None,
        }
    }

    /// Whether the spec says the same of every sample: a constant, or one for each sensor.
    pub fn is_constant(&self) -> bool {
        matches!(self, Self::Sensors(pair) if pair.is_constant())
    }

    /// Whether it is an estimate from the last second or so of samples, as networks and simple estimators make it, and no constant.
    pub fn is_estimate(&self) -> bool {
        matches!(self, Self::Sensors(_) | Self::DualProNet { .. }) && !self.is_constant()
    }

    fn from_call(call: &Call) -> Result<Self, SpecError> {
        let wrong = |problem: &str, usage: &'static str| SpecError::Arguments {
            call: call.to_string(),
            problem: problem.to_owned(),
            usage,
        };
        let of = |args: &[Arg], usage| {
            if args.is_empty() {
                return Err(wrong("the spec it is made of is missing", usage));
            }
            let text: Vec<String> = args.iter().map(written).collect();
            Ok(Box::new(text.join(",").parse::<Self>()?))
        };
        let of_no_run = |args: &[Arg], usage| {
            let of = of(args, usage)?;
            if of.is_learned() || of.learned_before().is_some() {
                return Err(wrong(OF_NO_RUN, usage));
            }
            Ok(of)
        };
        match call.name.as_str() {
            "dualpronet" => match call.args.as_slice() {
                [] => Ok(Self::DualProNet { accel: DEFAULT_TAG.into(), gyro: DEFAULT_TAG.into() }),
                [tag] => Ok(Self::DualProNet { accel: bare(tag), gyro: bare(tag) }),
                [accel, gyro] => Ok(Self::DualProNet { accel: bare(accel), gyro: bare(gyro) }),
                _ => Err(wrong("at most 2 tags", "dualpronet(accel,gyro)")),
            },
            "file" => match call.args.as_slice() {
                [path] => Ok(Self::File(bare(path).into())),
                _ => Err(wrong("one path, in quotes where it holds a comma or a bracket", "file(\"path\")")),
            },
            "oracle" if call.args.is_empty() => Ok(Self::Oracle),
            "oracle" => Err(wrong("at most 0 arguments", "oracle")),
            "shuffled" => Ok(Self::Shuffled(of(&call.args, "shuffled(spec)")?)),
            "self" if call.args.is_empty() => Ok(Self::Learned(Box::new("x1".parse()?))),
            "self" => Ok(Self::Learned(of_no_run(&call.args, "self(spec)")?)),
            "mean" => Ok(Self::Mean(of(&call.args, "mean(spec)")?)),
            "plus" => {
                let (last, rest) = match call.args.split_last() {
                    Some((last, rest)) if !rest.is_empty() => (last, rest),
                    _ => return Err(wrong("a spec and a constant are needed", names::PLUS)),
                };
                let constant = match written(last).parse()? {
                    Self::Sensors(pair) if pair.is_constant() => pair,
                    _ => return Err(wrong(NO_CONSTANT, names::PLUS)),
                };
                Ok(Self::Plus { of: of_no_run(rest, names::PLUS)?, constant })
            }
            _ => Ok(Self::MeanOfTrain(of_no_run(&call.args, "mean-of-train(spec)")?)),
        }
    }
}

/// Levels are a function of a run, not of a recording: nothing but the controls can be made of them.
const OF_NO_RUN: &str = "levels of `self` are known only once the odometry has run; mean(self) and shuffled(self) are made of a first run, and file(\"noise_learned.csv\"), which `dpn run --noise self` writes, may stand here";
const NO_CONSTANT: &str = "the last argument must be a constant, such as x4";

/// An argument as it was written.
fn written(arg: &Arg) -> String {
    match arg {
        Arg::Number(number) => number.to_string(),
        Arg::Text(text) => format!("\"{text}\""),
        Arg::Call(call) => call.to_string(),
    }
}

/// An argument without its quotes.
fn bare(arg: &Arg) -> String {
    match arg {
        Arg::Text(text) => text.clone(),
        other => written(other),
    }
}

impl FromStr for NoiseSpec {
    type Err = SpecError;

    fn from_str(spec: &str) -> Result<Self, SpecError> {
        let bare = spec.trim();
        if bare.to_ascii_lowercase().ends_with(".csv") && !bare.contains(['(', '"']) {
            return Err(SpecError::BarePath { path: bare.to_owned() });
        }
        let calls = Call::parse_list(spec)?;
        match calls.as_slice() {
            [call] if names::is_both(&call.name) => Self::from_call(call),
            calls => SensorPair::from_calls(spec, calls).map(Self::Sensors),
        }
    }
}

/// The specs of a list: between semicolons or blanks outside brackets, or, where there is neither, between commas outside brackets.
///
/// So `x1,x4,dualpronet` are three specs, as are `x1; x4,x1; dualpronet` (the middle one gives each sensor its own), and `x4,x1;` is one.
///
/// # Errors
/// No spec; a spec that is none.
pub fn parse_list(text: &str) -> Result<Vec<NoiseSpec>, SpecError> {
    let strong = split(text, &[';', ' ', '\t', '\n']);
    let parts = if strong.len() > 1 || text.trim_end().ends_with(';') { strong } else { split(text, &[',']) };
    let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    if parts.is_empty() {
        return Err(SpecError::NoSpec { text: text.to_owned() });
    }
    let mut specs: Vec<NoiseSpec> = Vec::with_capacity(parts.len());
    for part in parts {
        let spec = part.parse()?;
        if !specs.contains(&spec) {
            specs.push(spec);
        }
    }
    Ok(specs)
}

/// Cuts at any of `marks` outside brackets and quotes.
fn split(text: &str, marks: &[char]) -> Vec<String> {
    let (mut parts, mut part) = (Vec::new(), String::new());
    let (mut depth, mut quoted) = (0_usize, false);
    for c in text.trim().chars() {
        match c {
            '"' => quoted = !quoted,
            '(' if !quoted => depth += 1,
            ')' if !quoted => depth = depth.saturating_sub(1),
            _ => {}
        }
        if depth == 0 && !quoted && marks.contains(&c) {
            parts.push(std::mem::take(&mut part));
        } else {
            part.push(c);
        }
    }
    parts.push(part);
    parts.retain(|part| !part.trim().is_empty());
    parts.iter().map(|part| part.trim().to_owned()).collect()
}

impl TryFrom<String> for NoiseSpec {
    type Error = SpecError;

    fn try_from(spec: String) -> Result<Self, SpecError> {
        spec.parse()
    }
}

impl From<NoiseSpec> for String {
    fn from(spec: NoiseSpec) -> Self {
        spec.to_string()
    }
}

impl fmt::Display for NoiseSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sensors(pair) => write!(f, "{pair}"),
            Self::DualProNet { accel, gyro } if accel == gyro && accel == DEFAULT_TAG => {
                f.write_str("dualpronet")
            }
            Self::DualProNet { accel, gyro } if accel == gyro => write!(f, "dualpronet({accel})"),
            Self::DualProNet { accel, gyro } => write!(f, "dualpronet({accel},{gyro})"),
            Self::File(path) => write!(f, "file(\"{}\")", path.display()),
            Self::Oracle => f.write_str("oracle"),
            Self::Shuffled(of) => write!(f, "shuffled({of})"),
            Self::Mean(of) => write!(f, "mean({of})"),
            Self::MeanOfTrain(of) => write!(f, "mean-of-train({of})"),
            Self::Learned(of) if of.multiple() == Some(1.0) => f.write_str("self"),
            Self::Learned(of) => write!(f, "self({of})"),
            Self::Plus { of, constant } => write!(f, "plus({of},{constant})"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_reads_as_itself() {
        for (spec, canonical) in [
            ("x4", "x4"),
            ("x4, x1", "x4,x1"),
            ("const(.1,.01)", "const(0.1,0.01)"),
            ("diff2", "diff2"),
            ("dualpronet", "dualpronet"),
            ("dualpronet(sg11-s0)", "dualpronet"),
            ("dualpronet(sg5-s0)", "dualpronet(sg5-s0)"),
            ("dualpronet(sg5-s0, sg7-s1)", "dualpronet(sg5-s0,sg7-s1)"),
            ("file(noise/a.csv)", "file(\"noise/a.csv\")"),
            ("file(\"a (1), b.csv\")", "file(\"a (1), b.csv\")"),
            ("oracle", "oracle"),
            ("shuffled(mean(x4,x1))", "shuffled(mean(x4,x1))"),
            ("shuffled( sg(11, 2) )", "shuffled(sg(11,2))"),
            ("mean-of-train(dualpronet(sg5-s0))", "mean-of-train(dualpronet(sg5-s0))"),
            ("self", "self"),
            ("self(x1)", "self"),
            ("mean(self(x1))", "mean(self)"),
            ("shuffled(self(diff2))", "shuffled(self(diff2))"),
            ("self( mean(diff2) )", "self(mean(diff2))"),
            ("plus( sg(11, 2), x4 )", "plus(sg(11,2),x4)"),
            (
                "mean(plus(dualpronet(sg5-s0),const(.3,.01)))",
                "mean(plus(dualpronet(sg5-s0),const(0.3,0.01)))",
            ),
        ] {
            let read: NoiseSpec = spec.parse().unwrap();
            assert_eq!(read.to_string(), canonical, "{spec}");
            assert_eq!(canonical.parse::<NoiseSpec>().unwrap(), read, "{spec}");
        }
    }

    #[test]
    fn what_is_no_spec_is_refused_with_the_way_to_write_it() {
        for (spec, words) in [
            ("shufled(x1)", "did you mean `shuffled`?"),
            ("effective(0)", "0 is no span of seconds"),
            ("const(0,1)", "0 is no deviation"),
            ("shuffled", "shuffled(spec)"),
            ("mean(nothing)", "`nothing` is no noise spec"),
            ("oracle(3)", "at most 0"),
            ("file()", "one path"),
            ("noise/a.csv", "a noise track on disk is named file(\"noise/a.csv\")"),
            ("dualpronet(a,b,c)", "at most 2"),
            ("shuffled(x1),x2", "both sensors"),
            ("mean-of-train(self)", "once the odometry has run"),
            ("self(mean(self))", "once the odometry has run"),
            ("plus(shuffled(self),x4)", "once the odometry has run"),
            ("self(self(x4))", "once the odometry has run"),
            ("plus(self,x4)", "once the odometry has run"),
            ("plus(diff2)", "a spec and a constant"),
            ("plus(x1,diff2)", "must be a constant"),
        ] {
            let text = spec.parse::<NoiseSpec>().unwrap_err().to_string();
            assert!(text.contains(words), "{spec}: {text}");
        }
    }

    #[test]
    fn lists_are_cut_at_commas_or_where_a_semicolon_stands_at_semicolons() {
        let list = |text: &str| parse_list(text).unwrap().iter().map(ToString::to_string).collect::<Vec<_>>();
        assert_eq!(list("x0.5,x1,dualpronet"), ["x0.5", "x1", "dualpronet"]);
        assert_eq!(list("x1; x4,x1 ;mean(x4,x1)"), ["x1", "x4,x1", "mean(x4,x1)"]);
        assert_eq!(list("x4,x1;"), ["x4,x1"]);
        assert_eq!(list("x1 x4,x1"), ["x1", "x4,x1"]);
        assert_eq!(list("sg(11,2),mean(x4,x1)"), ["sg(11,2)", "mean(x4,x1)"]);
        assert_eq!(list("x1,x1,x2"), ["x1", "x2"]);
        assert!(parse_list(" ; ").is_err());
        assert!(parse_list("x1;what").is_err());
    }

    #[test]
    fn a_multiple_is_one_of_both_sensors() {
        let of = |spec: &str| spec.parse::<NoiseSpec>().unwrap().multiple();
        assert_eq!(of("x4"), Some(4.0));
        assert_eq!(of("x4,x1"), None);
        assert_eq!(of("mean(x4)"), None);
    }
}
