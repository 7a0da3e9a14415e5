//! What the network is asked for (decision 9).

use serde::{Deserialize, Serialize};
use std::fmt;

/// The deviation a window is labelled with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Label {
    /// The injected deviation alone (the paper).
    #[serde(rename = "sigma_inj")]
    Injected,
    /// `sqrt(injected^2 + own^2)`: with the white noise the window held before (`own::own_sigma`).
    #[serde(rename = "sigma_tot")]
    Total,
}

impl Label {
    /// Both labels.
    pub const ALL: [Self; 2] = [Self::Injected, Self::Total];

    /// The label of a window with `injected` noise on top of its `own`.
    pub fn of(self, injected: f64, own: f64) -> f64 {
        match self {
            Self::Injected => injected,
            Self::Total => injected.hypot(own),
        }
    }
}

impl fmt::Display for Label {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Injected => "sigma_inj",
            Self::Total => "sigma_tot",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn total_adds_variances() {
        assert_eq!(Label::Injected.of(3.0, 4.0), 3.0);
        assert_eq!(Label::Total.of(3.0, 4.0), 5.0);
    }
}
