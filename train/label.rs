//! What the network is asked for (decision 9).

use dpn_core::named;
use serde::{Deserialize, Serialize};

named!(
    /// The deviation a window is labelled with.
    #[derive(Serialize, Deserialize)]
    pub enum Label {
        /// The injected deviation alone (the paper).
        #[serde(rename = "sigma_inj")]
        Injected = "sigma_inj",
        /// `sqrt(injected^2 + own^2)`: with the white noise the window held before (`own::own_sigma`).
        #[serde(rename = "sigma_tot")]
        Total = "sigma_tot",
        /// The white deviation that errs as much in sums over [`NoiseConfig::span_s`](crate::config::NoiseConfig::span_s) as the injected white noise and the
        /// vibration beside it do ([`vibration`](crate::vibration)), by the processes' expectation.
        #[serde(rename = "sigma_eff")]
        Effective = "sigma_eff",
    }
);

impl Label {
    /// The labels that differ where white noise alone is injected; without vibration `sigma_eff` is `sigma_inj`.
    pub const OF_WHITE: [Self; 2] = [Self::Injected, Self::Total];

    /// The label of a window with `injected` white noise beside another deviation: its `own` for `sigma_tot`, what its vibration counts for
    /// `sigma_eff`.
    pub fn of(self, injected: f64, beside: f64) -> f64 {
        match self {
            Self::Injected => injected,
            Self::Total | Self::Effective => injected.hypot(beside),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn total_adds_variances() {
        assert_eq!(Label::Injected.of(3.0, 4.0), 3.0);
        assert_eq!(Label::Total.of(3.0, 4.0), 5.0);
        assert_eq!(Label::Effective.of(3.0, 4.0), 5.0);
    }
}
