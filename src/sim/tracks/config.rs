//! What tracks are made of: the world's kind, the tracker's habits and errors, the camera.

use super::camera::CameraSettings;
use super::world::World;
use dpn_core::config::{ConfigFault, Limit, Validate};

dpn_core::settings!(
    /// How ground truth becomes a smooth path.
    #[derive(Copy)]
    pub struct PathConfig {
        /// Span of the cubic fit that takes out the motion capture's own jitter \[s\], 0 to 10; 0 switches it off. Below five poses a span
        /// nothing is smoothed either. Default .1.
        pub smoothing_s: f64 = 0.1 => 0.0..=10.0,
        /// A longer step between poses \[s\] is a gap, above 0 and up to 10: no frame is made in it, and nothing is smoothed across. Default .1.
        pub longest_gap_s: f64 = 0.1 => Limit::AtMost(10.0),
    }
    impl Validate
);

dpn_core::settings!(
    /// Settings of simulated tracks. Tracks are a function of this, a path, the camera's stamps and a seed.
    pub struct TracksConfig {
        /// Kind of the world. Default `auto`, by the flight's size.
        pub world: World = World::Auto,
        /// Most points followed at a time, 1 to 10000. Default 150.
        pub max_tracks: usize = 150 => 1..=10_000,
        /// A track is born this far \[px\] from every other at least, 0 to 1000. Default 30.
        pub spacing_px: f64 = 30.0 => 0.0..=1000.0,
        /// Frames handed over a second \[Hz\], above 0 and up to 1000: every n-th of the camera's, n the nearest whole number. Default 10.
        pub rate_hz: f64 = 10.0 => Limit::AtMost(1000.0),
        /// White noise of a position, each axis \[px\], 0 to 100. Default .5.
        pub pixel_noise_px: f64 = 0.5 => 0.0..=100.0,
        /// Drift: what a camera frame adds to a track's error for good, each axis \[px\], 0 to 100. Default .04.
        pub drift_px: f64 = 0.04 => 0.0..=100.0,
        /// Share of the tracks that turn into outliers at a camera frame, 0 to 1. Default .003.
        pub outlier_share: f64 = 0.003 => 0.0..=1.0,
        /// How far an outlier slides a camera frame, in a direction of its own \[px\], 0 to 1000. Default 2.5.
        pub outlier_slide_px: f64 = 2.5 => 0.0..=1000.0,
        /// Share of the outliers that end at a camera frame, 0 to 1. Default .3.
        pub outlier_end_share: f64 = 0.3 => 0.0..=1.0,
        /// Mean time after which a track ends for no reason \[s\], above 0 and up to 1e9. Default 2.5: 2 % a frame at 20 Hz.
        pub life_time_s: f64 = 2.5 => Limit::AtMost(1e9),
        /// A track whose point moves farther than this from one camera frame to the next \[px\] ends; above 0 and up to 10000. Default 60.
        pub largest_motion_px: f64 = 60.0 => Limit::AtMost(10_000.0),
        /// A longer step between camera frames \[s\] ends all tracks, as a gap in the path does; above 0 and up to 1000. Default .5.
        pub longest_blind_s: f64 = 0.5 => Limit::AtMost(1000.0),
        /// Tracks of time t are made from the pose at t + this \[s\], -1 to 1: as if the ground truth's clock were late by it. Default 0.
        pub ground_truth_delay_s: f64 = 0.0 => -1.0..=1.0,
        /// How ground truth becomes a path.
        pub path: PathConfig = PathConfig::default(),
        /// The camera; without it the sequence's own where there is one, else EuRoC's cam0.
        pub camera: Option<CameraSettings> = None,
    }
);

impl TracksConfig {
    /// A tracker without errors: no noise, no drift, no outliers.
    pub fn ideal() -> Self {
        Self { pixel_noise_px: 0.0, drift_px: 0.0, outlier_share: 0.0, ..Self::default() }
    }

    /// The camera that tracks are made with.
    pub fn camera_or_default(&self) -> CameraSettings {
        self.camera.unwrap_or_default()
    }
}

impl Validate for TracksConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = self.outside();
        faults.table("path", self.path.faults());
        if let Some(camera) = &self.camera {
            camera.check(&mut faults);
        }
        faults.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    fn parsed(text: &str) -> Result<TracksConfig, dpn_io::config::ConfigError> {
        dpn_io::config::parse(text, Path::new("tracks.toml"))
    }

    #[test]
    fn the_file_of_defaults_says_what_the_program_does_without_it() {
        let expected = TracksConfig { camera: Some(CameraSettings::default()), ..TracksConfig::default() };
        assert_eq!(parsed(include_str!("../../../configs/tracks/euroc.toml")).unwrap(), expected);
        assert_eq!(parsed("").unwrap(), TracksConfig::default());
        let fish_eye = parsed(include_str!("../../../configs/tracks/fish-eye.toml")).unwrap();
        assert_ne!(fish_eye.camera, expected.camera);
        assert_eq!(TracksConfig { camera: None, ..fish_eye }, TracksConfig::default());
    }

    #[test]
    fn all_faults_are_named_at_once_with_key_value_and_bound() {
        let error = parsed(
            "max_tracks = 0\npixel_noise_px = nan\nlife_time_s = 0\n[path]\nlongest_gap_s = -1\n[camera]\nresolution = [0, 480]",
        )
        .unwrap_err()
        .to_string();
        for part in [
            "`max_tracks` is 0, but must be 1 to 10000",
            "`pixel_noise_px` is NaN, but must be 0 to 100",
            "`life_time_s` is 0, but must be above 0 and at most 1000000000",
            "`path.longest_gap_s` is -1, but must be above 0 and at most 10",
            "`camera.intrinsics` is [0, 480] with intrinsics",
        ] {
            assert!(error.contains(part), "{part}: {error}");
        }
    }

    #[test]
    fn a_resolved_configuration_reads_back_the_same_and_slips_are_named() {
        let config = TracksConfig { camera: Some(CameraSettings::default()), ..TracksConfig::ideal() };
        let text = serde_json::to_string(&config).unwrap();
        assert_eq!(serde_json::from_str::<TracksConfig>(&text).unwrap(), config);
        let error = parsed("world = \"garden\"").unwrap_err().to_string();
        assert!(
            error.contains("unknown variant `garden`, expected one of `auto`, `room`, `hall`"),
            "{error}"
        );
        assert_eq!(parsed("spacing = 3").unwrap_err().hint().as_deref(), Some("did you mean `spacing_px`?"));
    }
}
