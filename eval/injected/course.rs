//! The courses of what is added.

use dpn_core::named;
use serde::{Deserialize, Serialize};

named!(
    /// How what is added changes over a recording. Shares are of the time from the first sample to the last.
    #[derive(Serialize, Deserialize)]
    #[serde(rename_all = "kebab-case")]
    pub enum Course {
        /// Nothing is added.
        None = "none",
        /// White noise on all axes: x1 in the first third, x`factor` in the second, x1 in the third.
        Step = "step",
        /// White noise on all axes, growing evenly from x1 at the start to x`factor` at the end.
        Ramp = "ramp",
        /// As `step`, on the y axes alone; x and z stay at x1.
        OneAxis = "one-axis",
        /// No white noise: in the second third a sine of 90 Hz on all axes, of the deviation that `step` has there.
        Tone = "tone",
        /// No white noise: in the second half the biases are larger by x`factor`.
        BiasJump = "bias-jump",
    }
);

impl Course {
    /// All courses that add something.
    pub const ADDING: [Self; 5] = [Self::Step, Self::Ramp, Self::OneAxis, Self::Tone, Self::BiasJump];

    /// Deviation of the white noise added at `share` of the time on `axis` (0 to 2), in units of x1.
    pub(super) fn white(self, share: f64, axis: usize, factor: f64) -> f64 {
        match self {
            Self::None | Self::Tone | Self::BiasJump => 0.0,
            Self::Ramp => 1.0 + (factor - 1.0) * share,
            Self::OneAxis if axis != 1 => 1.0,
            Self::Step | Self::OneAxis => {
                if self.is_up(share) {
                    factor
                } else {
                    1.0
                }
            }
        }
    }

    /// Whether `share` of the time lies in the part in which the change is in force.
    pub(super) fn is_up(self, share: f64) -> bool {
        match self {
            Self::None | Self::Ramp => false,
            Self::Step | Self::OneAxis | Self::Tone => (1.0 / 3.0..2.0 / 3.0).contains(&share),
            Self::BiasJump => share >= 0.5,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn courses_are_what_their_names_say() {
        let at = |course: Course, axis| [0.0, 0.3, 0.4, 0.6, 0.7, 1.0].map(|s| course.white(s, axis, 5.0));
        assert_eq!(at(Course::Step, 0), [1.0, 1.0, 5.0, 5.0, 1.0, 1.0]);
        assert_eq!(at(Course::OneAxis, 1), at(Course::Step, 1));
        assert_eq!(at(Course::OneAxis, 2), [1.0; 6]);
        assert_eq!(at(Course::Ramp, 0)[0], 1.0);
        assert_eq!(at(Course::Ramp, 0)[5], 5.0);
        assert_eq!(at(Course::Tone, 0), [0.0; 6]);
        assert!(Course::Tone.is_up(0.5) && !Course::Tone.is_up(0.2) && Course::BiasJump.is_up(1.0));
        for course in Course::ADDING {
            assert_eq!(serde_json::to_string(&course).unwrap(), format!("\"{course}\""));
        }
    }
}
