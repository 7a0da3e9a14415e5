//! Settings of a reconciliation: no noise is among them, for its levels are found.

use dpn_core::config::{ConfigFault, ConfigFaults, Validate};

dpn_core::settings!(
    /// How a published ground truth is reconciled.
    #[derive(Copy)]
    pub struct TruthConfig {
        /// Between two keys of the estimate \[s\], .01 to .5. Default .1: an oscillation is lost in a sum over it.
        pub key_interval_s: f64 = 0.1,
        /// A longer step between published poses \[s\] is a gap, .01 to 10: across it the samples alone lead. Default .25.
        pub longest_gap_s: f64 = 0.25,
        /// How far both clocks may be apart \[s\], 0 to 10. Default 1.
        pub longest_delay_s: f64 = 1.0,
        /// Where the estimate's own deviation of position (root of the mean over the axes, \[m\]) is larger, nothing is written, 1e-4 to 1. Default .003.
        pub position_limit_m: f64 = 3e-3,
        /// The same of the rotation \[deg\], .01 to 10. Default .3.
        pub rotation_limit_deg: f64 = 0.3,
        /// The published poses beside each second of so many keys are kept out, to be predicted; 0 keeps none out. Default 0.
        pub hold_out: usize = 0,
        /// Most adjustments, 5 to 200. Default 40.
        pub most_iterations: usize = 40,
    }
);

impl Validate for TruthConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.within("key_interval_s", self.key_interval_s, 0.01, 0.5);
        faults.within("longest_gap_s", self.longest_gap_s, 0.01, 10.0);
        faults.within("longest_delay_s", self.longest_delay_s, 0.0, 10.0);
        faults.within("position_limit_m", self.position_limit_m, 1e-4, 1.0);
        faults.within("rotation_limit_deg", self.rotation_limit_deg, 0.01, 10.0);
        faults.within("most_iterations", self.most_iterations as f64, 5.0, 200.0);
        faults.0
    }
}
