//! Settings of a reconciliation: no noise is among them, for its levels are found.

dpn_core::settings!(
    /// How a published ground truth is reconciled.
    #[derive(Copy)]
    pub struct TruthConfig {
        /// Between two keys of the estimate \[s\], .01 to .5. Default .1: an oscillation is lost in a sum over it.
        pub key_interval_s: f64 = 0.1 => 0.01..=0.5,
        /// A longer step between published poses \[s\] is a gap, .01 to 10: across it the samples alone lead. Default .25.
        pub longest_gap_s: f64 = 0.25 => 0.01..=10.0,
        /// How far both clocks may be apart \[s\], 0 to 10. Default 1.
        pub longest_delay_s: f64 = 1.0 => 0.0..=10.0,
        /// Where the estimate's own deviation of position (root of the mean over the axes, \[m\]) is larger, nothing is written, 1e-4 to 1. Default .003.
        pub position_limit_m: f64 = 3e-3 => 1e-4..=1.0,
        /// The same of the rotation \[deg\], .01 to 10. Default .3.
        pub rotation_limit_deg: f64 = 0.3 => 0.01..=10.0,
        /// The published poses beside each second of so many keys are kept out, to be predicted; 0 keeps none out. Default 0.
        pub hold_out: usize = 0,
        /// Most adjustments, 5 to 200. Default 40.
        pub most_iterations: usize = 40 => 5..=200,
    }
    impl Validate
);
