//! Which corners are taken.

use dpn_core::config::{ConfigFault, ConfigFaults, Validate};

dpn_core::settings!(
    /// Settings of the detector.
    #[derive(Copy)]
    pub struct CornerConfig {
        /// Most points in a frame, tracked ones among them, 1 to 2000. Default 150, VINS-Mono's for EuRoC.
        pub most: usize = 150,
        /// Smallest response, as a share of the image's largest, 0 to 1. Default .01, VINS-Mono's.
        pub quality: f64 = 0.01,
        /// Smallest response at all \[(grey/px)^2\], 0 to 1e4: noise in a dark image has corners too. Default 1.
        pub least: f64 = 1.0,
        /// Least distance between points \[px\], 1 to 200. Default 30, VINS-Mono's for EuRoC.
        pub distance_px: f64 = 30.0,
        /// Least distance from the image's edge \[px\], 1 to 100. Default 5.
        pub edge_px: usize = 5,
        /// Cells in a row that share the points, 0 to 64; 0 takes the strongest wherever they are. Default 8.
        ///
        /// A cell is square; one that has half as much again as its share waits until all others had their turn.
        pub cells: usize = 8,
    }
);

impl Validate for CornerConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        faults.within("most", self.most, 1, 2000);
        faults.within("quality", self.quality, 0.0, 1.0);
        faults.within("least", self.least, 0.0, 1e4);
        faults.within("distance_px", self.distance_px, 1.0, 200.0);
        faults.within("edge_px", self.edge_px, 1, 100);
        faults.within("cells", self.cells, 0, 64);
        faults.0
    }
}
