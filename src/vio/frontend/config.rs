//! Settings of the whole front-end.

use super::corners::CornerConfig;
use super::klt::KltConfig;
use super::ransac::RansacConfig;
use dpn_core::config::{ConfigFault, Limit, Validate};

dpn_core::settings!(
    /// Settings of the front-end.
    #[derive(Copy)]
    pub struct FrontEndConfig {
        /// Frames handed over a second, above 0, at most 1000; images between them are tracked through. Default 10, VINS-Mono's.
        pub rate_hz: f64 = 10.0 => Limit::AtMost(1000.0),
        /// Time from the first line's exposure to the last's \[s\], -.1 (read out from below) to .1, 0 where all are taken at once; images are stamped at their
        /// middle line (a stamp elsewhere is an offset of the camera's clock). Without it, it is found from how turns bend the flow of points.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub readout_s: Option<f64> = None,
        /// What is added to the camera's stamps \[s\], -10 to 10; without it, it is found from the turns of camera and gyroscope, up to .25 s.
        #[serde(skip_serializing_if = "Option::is_none")]
        pub time_offset_s: Option<f64> = None,
        /// New points.
        pub corners: CornerConfig = CornerConfig::default(),
        /// Tracking from image to image.
        pub klt: KltConfig = KltConfig::default(),
        /// Consensus between frames that are handed over.
        pub ransac: RansacConfig = RansacConfig::default(),
    }
);

impl Validate for FrontEndConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = self.outside();
        if let Some(readout_s) = self.readout_s {
            faults.within("readout_s", readout_s, -0.1, 0.1);
        }
        if let Some(offset_s) = self.time_offset_s {
            faults.within("time_offset_s", offset_s, -10.0, 10.0);
        }
        faults.table("corners", self.corners.faults());
        faults.table("klt", self.klt.faults());
        faults.table("ransac", self.ransac.faults());
        faults.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_io::config::parse;
    use std::path::Path;

    #[test]
    fn every_fault_is_named_at_once_with_its_part() {
        let text = "rate_hz = 0.0\n[klt]\nwindow = 20\n[corners]\nmost = 0\n[ransac]\nthreshold_px = 0";
        let error = parse::<FrontEndConfig>(text, Path::new("f.toml")).unwrap_err().to_string();
        for key in
            ["`rate_hz` is 0", "`klt.window` is 20", "`corners.most` is 0", "`ransac.threshold_px` is 0"]
        {
            assert!(error.contains(key), "{key} not in {error}");
        }
        let nan = FrontEndConfig { readout_s: Some(f64::NAN), ..FrontEndConfig::default() };
        assert_eq!(nan.faults().len(), 1);
        assert!(FrontEndConfig::default().faults().is_empty());
    }

    #[test]
    fn a_mistyped_key_is_refused() {
        let error = parse::<FrontEndConfig>("[klt]\nwindows = 21", Path::new("f.toml")).unwrap_err();
        assert_eq!(error.hint().as_deref(), Some("did you mean `window`?"));
    }
}
