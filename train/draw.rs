//! One training example: a window, changed in ways that do not change its noise, with white noise added and, where asked for, vibration.
//!
//! Everything about example (epoch, window) comes from the stream `(seed, "train", sensor, epoch, window)`, so examples
//! can be made in any order and on any thread (decision 11).

use crate::label::Label;
use crate::levels::Levels;
use crate::sensor::{SensorDraw, SensorEffects};
use crate::vibration::{VibrationDraw, effective};
use crate::windows::WindowSet;
use dpn_core::SampleRate;
use dpn_core::random::Stream;
use rand::Rng;
use rand_distr::{Distribution, StandardNormal};

dpn_core::settings!(
    /// Changes to a base window that leave the question the same; each key switches one.
    #[derive(Copy)]
    pub struct Augment {
        /// Start the window up to a window later than its place in the disjoint cut.
        pub offset: bool = true,
        /// Flip the sign, half of the time.
        pub sign: bool = true,
        /// Run time backwards, half of the time.
        pub reverse: bool = true,
        /// Share of the windows whose base is made larger or smaller about its mean: other motion than the recordings hold.
        pub grow_share: f64 = 0.0 => 0.0..=1.0,
        /// Smallest factor of that change, at most 1; factors are log-uniform.
        pub shrink: f64 = 1.0 => 0.01..=1.0,
        /// Largest factor of that change, at least 1.
        pub grow: f64 = 1.0 => 1.0..=100.0,
    }
);

impl Augment {
    /// No change at all: the paper.
    pub const NONE: Self =
        Self { offset: false, sign: false, reverse: false, grow_share: 0.0, shrink: 1.0, grow: 1.0 };
}

/// What is drawn for every example.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DrawRule {
    /// Injected deviations.
    pub levels: Levels,
    /// What the label counts.
    pub label: Label,
    /// What is injected beside white noise.
    pub vibration: Option<VibrationDraw>,
    /// What sensors do to all of it.
    pub sensor: Option<SensorDraw>,
    /// Samples of the sums of [`Label::Effective`].
    pub span: usize,
    /// Of the windows.
    pub rate: SampleRate,
    /// Changes to the base.
    pub augment: Augment,
}

/// Adds white noise of deviation `sigma` to `window`.
pub fn inject(window: &mut [f64], sigma: f64, rng: &mut impl Rng) {
    for value in window {
        let unit: f64 = StandardNormal.sample(rng);
        *value += sigma * unit;
    }
}

impl DrawRule {
    /// Writes the example of window `index` drawn from `stream` into `out` and returns its label \[unit of the sensor\].
    ///
    /// # Shapes
    /// `out`: a window's samples.
    pub(crate) fn example_into(
        &self,
        set: &WindowSet,
        index: usize,
        stream: &Stream,
        out: &mut [f64],
    ) -> f64 {
        let mut rng = stream.rng();
        let level = self.levels.draw(&mut rng);
        // Every choice is drawn whether it is used or not: switching one on moves no other.
        let offset = rng.random_range(0..=set.slack(index));
        let (flip, reverse) = (rng.random::<bool>(), rng.random::<bool>());
        let (grows, growth): (f64, f64) = (rng.random(), rng.random());
        let offset = if self.augment.offset { offset } else { 0 };
        set.base_into(index, offset, out);
        if self.augment.sign && flip {
            out.iter_mut().for_each(|v| *v = -*v);
        }
        if self.augment.reverse && reverse {
            out.reverse();
        }
        if grows < self.augment.grow_share {
            let Augment { shrink, grow, .. } = self.augment;
            let factor = shrink * (grow / shrink).powf(growth);
            let mean = out.iter().sum::<f64>() / out.len() as f64;
            out.iter_mut().for_each(|v| *v = mean + factor * (*v - mean));
        }
        let effects = self.effects(stream);
        let beside = match self.label {
            Label::Injected => 0.0,
            Label::Total => set.own_sigma(out),
            Label::Effective => set.flight_sigma(index, out).hypot(self.vibrate(&effects, stream, out)),
        };
        inject(out, level, &mut rng);
        effects.apply(out, self.rate);
        self.label.of(level, beside)
    }

    /// What the sensor of the window drawn from `stream` does.
    pub(crate) fn effects(&self, stream: &Stream) -> SensorEffects {
        self.sensor.map_or_else(SensorEffects::default, |draw| draw.draw(stream))
    }

    /// Adds the vibration drawn from `stream` to `out` and returns what it counts over the span; none behind a low pass, which would take what the label counts.
    pub(crate) fn vibrate(&self, effects: &SensorEffects, stream: &Stream, out: &mut [f64]) -> f64 {
        if effects.low_pass.is_some() {
            return 0.0;
        }
        let Some(vibration) = self.vibration.and_then(|draw| draw.draw(out.len(), self.rate, stream)) else {
            return 0.0;
        };
        for (value, tone) in out.iter_mut().zip(&vibration.samples) {
            *value += tone;
        }
        effective(&vibration.tones, self.span, self.rate)
    }
}
