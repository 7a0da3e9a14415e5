//! What a rendered camera is made of: the world's kind, lens, sensor, exposure, blur by motion, line readout, dark phases, gaps.

use crate::tracks::{CameraSettings, PathConfig, World};
use dpn_core::config::{ConfigFault, Validate};

dpn_core::settings!(
    /// The lens, beside the geometry that the calibration says.
    #[derive(Copy)]
    pub struct LensConfig {
        /// Standard deviation of the blur of lens and pixel \[px\], 0 to 2. Default .45.
        pub blur_px: f64 = 0.45 => 0.0..=2.0,
        /// Share of the light that is lost in the corner farthest from the principal point, 0 to .95. Default .25.
        pub vignetting: f64 = 0.25 => 0.0..=0.95,
        /// Standard deviation, an axis, of what the calibration does not know of the lens \[px\], 0 to 2: a smooth field that stays with the camera. Default .3,
        /// as EuRoC's has it.
        pub uncalibrated_px: f64 = 0.3 => 0.0..=2.0,
    }
);

dpn_core::settings!(
    /// Noise of a pixel: variance = gain^2 read^2 + gain shot grey, with the gain beyond what a longer exposure gives.
    #[derive(Copy)]
    pub struct SensorConfig {
        /// Noise of a dark pixel, without that of rounding \[grey\], 0 to 50. Default .47, as EuRoC's pictures have it.
        pub read_grey: f64 = 0.47 => 0.0..=50.0,
        /// What a grey value adds to the variance \[grey\], 0 to 10. Default .0145, as EuRoC's pictures have it.
        pub shot_grey: f64 = 0.0145 => 0.0..=10.0,
    }
);

dpn_core::settings!(
    /// How bright pictures are.
    ///
    /// The mean grey value is led to `target_grey` with a lag of a few tenths of a second, first by a longer exposure, then by gain; on top
    /// of that the exposure changes at random.
    #[derive(Copy)]
    pub struct ExposureConfig {
        /// Mean grey value that is aimed at, 1 to 254. Default 128.
        pub target_grey: f64 = 128.0 => 1.0..=254.0,
        /// How many times longer than in mean light the exposure may be, 1 to 100; what is missing then is gain. Default 3.
        pub longest: f64 = 3.0 => 1.0..=100.0,
        /// Largest gain, 1 to 100. Default 8.
        pub most_gain: f64 = 8.0 => 1.0..=100.0,
        /// Standard deviation of the logarithm of random changes, 0 to 2. Default .04.
        pub change: f64 = 0.04 => 0.0..=2.0,
        /// A random change comes this often \[s\], .1 to 1000, and takes a tenth of that. Default 3.
        pub change_every_s: f64 = 3.0 => 0.1..=1000.0,
    }
);

dpn_core::settings!(
    /// Blur while the shutter is open.
    #[derive(Copy)]
    pub struct MotionBlurConfig {
        /// How long the shutter is open in mean light \[s\], 0 to .05; 0 switches blur off. Its middle is the image's stamp. Default 0.
        pub exposure_s: f64 = 0.0 => 0.0..=0.05,
        /// Most instants an image is the mean of, 2 to 64: each takes as long as an image without blur. Default 8.
        pub most_instants: usize = 8 => 2..=64,
    }
);

dpn_core::settings!(
    /// Images that a camera loses.
    #[derive(Copy)]
    pub struct GapConfig {
        /// A gap comes this often \[s\], twice `longest_s` to 1000. Default 10.
        pub every_s: f64 = 10.0,
        /// Longest gap \[s\], 0 to 10; each is drawn evenly up to it. 0 for none. Default 0.
        pub longest_s: f64 = 0.0 => 0.0..=10.0,
    }
);

dpn_core::settings!(
    /// Phases in which there is little light.
    #[derive(Copy)]
    pub struct LowLightConfig {
        /// Share of the time, 0 to 1. Default 0.
        pub share: f64 = 0.0 => 0.0..=1.0,
        /// Length of a phase \[s\], .5 to 1000. Default 6.
        pub length_s: f64 = 6.0 => 0.5..=1000.0,
        /// Light left, .001 to 1. Default .1.
        pub light: f64 = 0.1 => 0.001..=1.0,
    }
);

dpn_core::settings!(
    /// Settings of a rendered camera. Images are a function of this, a path, the camera's stamps and a seed.
    pub struct RenderConfig {
        /// Kind of the world. Default `auto`, by the flight's size.
        pub world: World = World::Auto,
        /// Contrast of all textures, 0 to 2; 1 is as they are painted. Default 1.
        pub contrast: f64 = 1.0 => 0.0..=2.0,
        /// Share of the walls' fields that show nothing but paint, 0 to 1. Default 0.
        pub bare: f64 = 0.0 => 0.0..=1.0,
        /// Time from the first line's exposure to the last's \[s\], 0 to .1; the middle line is exposed at the image's stamp. Default 0, all
        /// lines at once.
        pub readout_s: f64 = 0.0 => 0.0..=0.1,
        /// An image of time t is taken from the pose at t + this \[s\], -1 to 1: as if the ground truth's clock were late by it. Default 0.
        pub ground_truth_delay_s: f64 = 0.0 => -1.0..=1.0,
        /// How ground truth becomes a path.
        pub path: PathConfig = PathConfig::default(),
        /// The lens.
        pub lens: LensConfig = LensConfig::default(),
        /// The sensor.
        pub sensor: SensorConfig = SensorConfig::default(),
        /// Exposure.
        pub exposure: ExposureConfig = ExposureConfig::default(),
        /// Blur by motion.
        pub motion_blur: MotionBlurConfig = MotionBlurConfig::default(),
        /// Dark phases.
        pub low_light: LowLightConfig = LowLightConfig::default(),
        /// Images that are lost.
        pub gaps: GapConfig = GapConfig::default(),
        /// The camera; without it the sequence's own where there is one, else EuRoC's cam0.
        pub camera: Option<CameraSettings> = None,
    }
);

impl RenderConfig {
    /// A camera without noise, lens blur, vignetting, errors of calibration and changes of exposure.
    pub fn ideal() -> Self {
        Self {
            lens: LensConfig { blur_px: 0.0, vignetting: 0.0, uncalibrated_px: 0.0 },
            sensor: SensorConfig { read_grey: 0.0, shot_grey: 0.0 },
            exposure: ExposureConfig { change: 0.0, ..ExposureConfig::default() },
            ..Self::default()
        }
    }

    /// The camera that images are taken with.
    pub fn camera_or_default(&self) -> CameraSettings {
        self.camera.unwrap_or_default()
    }
}

impl Validate for RenderConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = self.outside();
        faults.table("lens", self.lens.outside().0);
        faults.table("sensor", self.sensor.outside().0);
        faults.table("exposure", self.exposure.outside().0);
        faults.table("motion_blur", self.motion_blur.outside().0);
        faults.table("low_light", self.low_light.outside().0);
        faults.table("gaps", self.gaps.outside().0);
        faults.within("gaps.every_s", self.gaps.every_s, 2.0 * self.gaps.longest_s, 1000.0);
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
    use dpn_io::config::parse;
    use std::path::Path;

    fn parsed(text: &str) -> Result<RenderConfig, String> {
        parse(text, Path::new("r.toml")).map_err(|error| error.to_string())
    }

    #[test]
    fn the_file_that_comes_with_the_program_is_the_default() {
        let expected = RenderConfig { camera: Some(CameraSettings::default()), ..RenderConfig::default() };
        assert_eq!(parsed(include_str!("../../../configs/images/euroc.toml")).unwrap(), expected);
        let fish_eye = parsed(include_str!("../../../configs/images/fish-eye.toml")).unwrap();
        let phone = parsed(include_str!("../../../configs/images/phone.toml")).unwrap();
        assert!(phone.bare > 0.0 && phone.readout_s == 0.03 && phone.gaps.longest_s == 0.4);
        assert_ne!(fish_eye.camera, expected.camera);
        assert_eq!(RenderConfig { camera: None, ..fish_eye }, RenderConfig::default());
    }

    #[test]
    fn every_fault_is_named_at_once() {
        let text = "contrast = -1.0\nbare = 2.0\nreadout_s = 1.0\n[sensor]\nshot_grey = nan\n[exposure]\nmost_gain = 0.5\n[path]\nsmoothing_s = 11.0\n\
            [motion_blur]\nexposure_s = 1.0\nmost_instants = 1\n[low_light]\nlight = 0.0\n[gaps]\nlongest_s = 11.0\n[camera]\nresolution = [0, 480]";
        let error = parsed(text).unwrap_err();
        for key in [
            "contrast",
            "sensor.shot_grey",
            "exposure.most_gain",
            "path.smoothing_s",
            "motion_blur.exposure_s",
            "motion_blur.most_instants",
            "low_light.light",
            "bare",
            "readout_s",
            "gaps.longest_s",
            "gaps.every_s",
            "camera.intrinsics",
        ] {
            assert!(error.contains(&format!("`{key}` is")), "{key} not in {error}");
        }
        assert!(RenderConfig::default().faults().is_empty() && RenderConfig::ideal().faults().is_empty());
    }
}
