//! Which corners are taken.

dpn_core::settings!(
    /// Settings of the detector.
    #[derive(Copy)]
    pub struct CornerConfig {
        /// Most points in a frame, tracked ones among them, 1 to 2000. Default 150, VINS-Mono's for EuRoC.
        pub most: usize = 150 => 1..=2000,
        /// Smallest response, as a share of the image's largest, 0 to 1. Default .01, VINS-Mono's.
        pub quality: f64 = 0.01 => 0.0..=1.0,
        /// Smallest response at all \[(grey/px)^2\], 0 to 1e4: noise in a dark image has corners too. Default 1.
        pub least: f64 = 1.0 => 0.0..=1e4,
        /// Least distance between points \[px\], 1 to 200. Default 30, VINS-Mono's for EuRoC.
        pub distance_px: f64 = 30.0 => 1.0..=200.0,
        /// Least distance from the image's edge \[px\], 1 to 100. Default 5.
        pub edge_px: usize = 5 => 1..=100,
        /// Cells in a row that share the points, 0 to 64; 0 takes the strongest wherever they are. Default 8.
        ///
        /// A cell is square; one that has half as much again as its share waits until all others had their turn.
        pub cells: usize = 8 => 0..=64,
    }
    impl Validate
);
