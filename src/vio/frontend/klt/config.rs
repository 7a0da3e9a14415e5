//! How points are tracked from image to image.

use dpn_core::config::{ConfigFault, Limit, Validate};

dpn_core::settings!(
    /// Settings of the tracker.
    #[derive(Copy)]
    pub struct KltConfig {
        /// Side of the window \[px\], odd, 7 to 29. Default 21, VINS-Mono's.
        pub window: usize = 21,
        /// Images in the pyramid, the full one among them, 1 to 6. Default 4, VINS-Mono's.
        pub levels: usize = 4 => 1..=6,
        /// Images in the pyramid for a point whose way is foreseen, 1 to 6; one that is lost so is looked for again with `levels`. Default 2.
        ///
        /// The way is foreseen where the camera's turn is known and what the point moved beyond it between the last two images.
        pub foreseen_levels: usize = 2 => 1..=6,
        /// Most Gauss-Newton steps a level, 1 to 100. Default 30, OpenCV's.
        pub iterations: usize = 30 => 1..=100,
        /// A step below this ends the search \[px\], above 0, at most 1. Default .01, OpenCV's.
        pub epsilon_px: f64 = 0.01 => Limit::AtMost(1.0),
        /// Smallest eigenvalue of the mean of `g g^T` over a window that can be tracked \[(grey/px)^2\], 0 to 1e4. Default .1, OpenCV's.
        pub min_eigenvalue: f64 = 0.1 => 0.0..=1e4,
        /// Whether the window may turn, grow and shear on the finest level. Default yes; VINS-Mono and OpenCV's tracker only shift it.
        pub affine: bool = true,
        /// Whether a track is held to the window it began with where a frame is handed over, so that it does not slide over its surface.
        /// Default yes; VINS-Mono's and OpenCV's trackers know the last image's alone.
        pub template: bool = true,
        /// Smallest correlation of the window with where it was found, gain and offset aside, 0 to 1; 0 switches the check off. Default .5.
        ///
        /// In noise a search ends where it began, and so does the way back: that a point came home does not say that it was found.
        pub min_correlation: f64 = 0.5 => 0.0..=1.0,
        /// A point tracked back must come home within this \[px\]; 0 switches the check off. Default .5.
        pub back_px: f64 = 0.5 => 0.0..=100.0,
        /// Images in the pyramid for the way back, which starts at home, 1 to 6. Default 2.
        pub back_levels: usize = 2 => 1..=6,
    }
);

impl Validate for KltConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = self.outside();
        let window = self.window;
        faults.check((7..=29).contains(&window) && window % 2 == 1, "window", window, "odd, 7 to 29");
        faults.0
    }
}
