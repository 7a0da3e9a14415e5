//! One simple estimator, named and parametrised.

use super::names::ESTIMATORS;
use super::{Arg, Call, SpecError};
use crate::estimate::moving::{Memory, Moving};
use crate::estimate::{
    AxisSigma, EachSample, EstimatorError, HopWindow, Mad2, Schedule, WaveletMad, WindowSigma, allan,
    differences, sg_residual,
};
use crate::signal::Wavelet;
use std::fmt;
use std::sync::Arc;

/// A simple estimator and its parameters; `Display` writes its spec.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum EstimatorSpec {
    /// `sg(window,order)`
    Sg {
        /// The filter's window, odd.
        window: usize,
        /// The polynomial's order.
        order: usize,
    },
    /// `diff1` to `diff4`
    Diff {
        /// Order of the differences.
        order: usize,
    },
    /// `mad2`
    Mad2,
    /// `wavelet(family)`
    Wavelet(Wavelet),
    /// `allan`
    Allan,
    /// `running` or `running(first)`
    Running {
        /// Samples it takes before it holds; `None`: all.
        first: Option<usize>,
    },
    /// `sliding` or `sliding(length)`
    Sliding {
        /// Samples it looks back; `None`: the schedule's window.
        length: Option<usize>,
    },
    /// `ewma(alpha)`
    Ewma {
        /// Weight of the latest sample.
        alpha: f64,
    },
    /// `kalman(q)`
    Kalman {
        /// Variance of the level's step over the noise's.
        ratio: f64,
    },
}

impl EstimatorSpec {
    /// One of every kind, each with its default parameters.
    pub fn all() -> Vec<Self> {
        let bare = |(name, _): (&str, _)| {
            let call = Call { name: name.to_owned(), args: Vec::new() };
            Self::from_call(&call).ok().flatten().expect("every estimator has defaults")
        };
        ESTIMATORS.into_iter().map(bare).collect()
    }

    /// The estimator that `call` names; `None` when it names none.
    ///
    /// # Errors
    /// Arguments that do not fit in number or kind. Their range is checked when the estimator is made.
    pub(crate) fn from_call(call: &Call) -> Result<Option<Self>, SpecError> {
        let Some((_, usage)) = ESTIMATORS.into_iter().find(|(name, _)| *name == call.name) else {
            return Ok(None);
        };
        let arguments = Arguments { call, usage };
        let spec = match call.name.as_str() {
            "sg" => {
                arguments.at_most(2)?;
                Self::Sg {
                    window: arguments.count(0)?.unwrap_or(11),
                    order: arguments.count(1)?.unwrap_or(2),
                }
            }
            "wavelet" => Self::Wavelet(arguments.family()?),
            "running" => Self::Running { first: arguments.at_most(1)?.count(0)? },
            "sliding" => Self::Sliding { length: arguments.at_most(1)?.count(0)? },
            "ewma" => Self::Ewma { alpha: arguments.at_most(1)?.number(0)?.unwrap_or(0.01) },
            "kalman" => Self::Kalman { ratio: arguments.at_most(1)?.number(0)?.unwrap_or(0.1) },
            bare => {
                arguments.at_most(0)?;
                match bare {
                    "mad2" => Self::Mad2,
                    "allan" => Self::Allan,
                    "diff1" => Self::Diff { order: 1 },
                    "diff2" => Self::Diff { order: 2 },
                    "diff3" => Self::Diff { order: 3 },
                    _ => Self::Diff { order: 4 },
                }
            }
        };
        Ok(Some(spec))
    }

    /// The estimator for windows of `samples`; a streaming one answers with its value after the window, from fresh.
    ///
    /// # Errors
    /// Parameters out of range; `samples` below what it needs.
    pub fn for_windows(&self, samples: usize) -> Result<Arc<dyn WindowSigma>, EstimatorError> {
        let estimator: Arc<dyn WindowSigma> = match *self {
            Self::Sg { window, order } => Arc::new(sg_residual(window, order, samples)?),
            Self::Diff { order } => Arc::new(differences(order, samples)?),
            Self::Mad2 => Arc::new(Mad2),
            Self::Wavelet(wavelet) => Arc::new(WaveletMad::new(wavelet)),
            Self::Allan => Arc::new(allan(samples)?),
            Self::Running { .. } | Self::Sliding { .. } | Self::Ewma { .. } | Self::Kalman { .. } => {
                Arc::new(Moving::new(self.memory(samples).expect("a moving variance has a memory"))?)
            }
        };
        let needs = estimator.min_len();
        if samples < needs {
            return Err(EstimatorError::WindowTooShort { name: self.to_string(), needs, window: samples });
        }
        Ok(estimator)
    }

    /// Three independent axes: window estimators on `schedule`, streaming ones updated at every sample after the
    /// first `schedule.window`.
    ///
    /// # Errors
    /// As [`for_windows`](Self::for_windows); a schedule of zeros.
    pub(crate) fn axes(&self, schedule: Schedule) -> Result<[Box<dyn AxisSigma>; 3], EstimatorError> {
        let Schedule { window, hop, .. } = schedule;
        if window == 0 || hop == 0 {
            return Err(EstimatorError::EmptySchedule { window, hop });
        }
        if let Some(memory) = self.memory(window) {
            let axis = || Moving::new(memory).map(|moving| Box::new(EachSample::new(moving, window)));
            return Ok([axis()?, axis()?, axis()?]);
        }
        let estimator = self.for_windows(window)?;
        let axis = || Box::new(HopWindow::new(Box::new(Arc::clone(&estimator)), window, hop));
        Ok([axis(), axis(), axis()])
    }

    /// What a moving variance remembers where windows have `samples`; `None` for a window estimator.
    fn memory(&self, samples: usize) -> Option<Memory> {
        match *self {
            Self::Running { first } => Some(Memory::First(first.unwrap_or(usize::MAX))),
            Self::Sliding { length } => Some(Memory::Last(length.unwrap_or(samples))),
            Self::Ewma { alpha } => Some(Memory::Fading(alpha)),
            Self::Kalman { ratio } => Some(Memory::Level(ratio)),
            Self::Sg { .. } | Self::Diff { .. } | Self::Mad2 | Self::Wavelet(_) | Self::Allan => None,
        }
    }
}

impl fmt::Display for EstimatorSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Sg { window, order } => write!(f, "sg({window},{order})"),
            Self::Diff { order } => write!(f, "diff{order}"),
            Self::Mad2 => f.write_str("mad2"),
            Self::Wavelet(wavelet) => write!(f, "wavelet({})", wavelet.name()),
            Self::Allan => f.write_str("allan"),
            Self::Running { first: None } => f.write_str("running"),
            Self::Running { first: Some(first) } => write!(f, "running({first})"),
            Self::Sliding { length: None } => f.write_str("sliding"),
            Self::Sliding { length: Some(length) } => write!(f, "sliding({length})"),
            Self::Ewma { alpha } => write!(f, "ewma({alpha})"),
            Self::Kalman { ratio } => write!(f, "kalman({ratio})"),
        }
    }
}

/// A call's arguments, read by place and kind.
#[derive(Clone, Copy)]
pub(super) struct Arguments<'a> {
    pub(super) call: &'a Call,
    pub(super) usage: &'static str,
}

impl Arguments<'_> {
    pub(super) fn wrong(&self, problem: String) -> SpecError {
        SpecError::Arguments { call: self.call.to_string(), problem, usage: self.usage }
    }

    pub(super) fn at_most(self, most: usize) -> Result<Self, SpecError> {
        match self.call.args.len() {
            given if given > most => Err(self.wrong(format!("{given} arguments, at most {most} fit"))),
            _ => Ok(self),
        }
    }

    pub(super) fn number(&self, place: usize) -> Result<Option<f64>, SpecError> {
        match self.call.args.get(place) {
            None => Ok(None),
            Some(Arg::Number(number)) => Ok(Some(*number)),
            Some(_) => Err(self.wrong(format!("argument {} is no number", place + 1))),
        }
    }

    fn count(&self, place: usize) -> Result<Option<usize>, SpecError> {
        match self.number(place)? {
            None => Ok(None),
            Some(number) if number >= 0.0 && number.fract() == 0.0 && number <= 1e9 => {
                Ok(Some(number as usize))
            }
            Some(number) => Err(self.wrong(format!("{number} is no number of samples or order"))),
        }
    }

    fn family(&self) -> Result<Wavelet, SpecError> {
        match self.at_most(1)?.call.args.first() {
            None => Ok(Wavelet::Db4),
            Some(Arg::Call(word)) if word.args.is_empty() => Wavelet::called(&word.name)
                .ok_or_else(|| self.wrong(format!("`{}` is no known family", word.name))),
            Some(_) => Err(self.wrong("the argument is no family".to_owned())),
        }
    }
}
