//! A log in the worker's memory, and what is asked of it.

use crate::failure::Failure;
use crate::picture;
use crate::source::{Bytes, Source};
use dpn_core::{ImuRecording, Recorded};
use dpn_io::noise_formats::{Format, Given, NoiseCalibration, parse, write};
use dpn_logs::{LogOptions, read_stream};
use dpn_probe::Finding;
use dpn_probe::allan::compare::{FigureCheck, compare};
use dpn_probe::allan::{AllanLog, report};
use dpn_probe::doctor::examine_log;
use dpn_probe::log_noise::{Along, Plan};
use dpn_pronet::network::Network;
use std::path::Path;
use wasm_bindgen::JsError;
use wasm_bindgen::prelude::wasm_bindgen;

/// The networks that `dpn noise` asks where no others are named.
const NETWORKS: [(&str, &[u8]); 6] = [
    ("models/accel/flight-s0.safetensors", include_bytes!("../models/accel/flight-s0.safetensors")),
    ("models/accel/flight-s0@100.safetensors", include_bytes!("../models/accel/flight-s0@100.safetensors")),
    ("models/accel/flight-s0@50.safetensors", include_bytes!("../models/accel/flight-s0@50.safetensors")),
    ("models/gyro/flight-s0.safetensors", include_bytes!("../models/gyro/flight-s0.safetensors")),
    ("models/gyro/flight-s0@100.safetensors", include_bytes!("../models/gyro/flight-s0@100.safetensors")),
    ("models/gyro/flight-s0@50.safetensors", include_bytes!("../models/gyro/flight-s0@50.safetensors")),
];
/// Formats beside those that `dpn allan` and `dpn noise` write.
const MORE: [Format; 2] = [Format::Okvis2, Format::Ros];
/// Samples from one answer to the next, as `dpn noise` has it by default.
const EVERY: usize = 10;

#[wasm_bindgen]
extern "C" {
    /// A function of the worker's: the share of the noise that is made.
    #[wasm_bindgen(js_name = noiseProgress)]
    fn progress(share: f64);
}

/// A log that was read.
#[wasm_bindgen]
#[derive(Debug)]
pub struct Session {
    name: String,
    recording: ImuRecording,
    check: String,
    told: String,
    config: Option<(String, Vec<u8>)>,
}

#[wasm_bindgen]
impl Session {
    /// Reads a log and examines it; `topic` is empty, or one of a bag's.
    ///
    /// # Errors
    /// A sentence, and a remedy on a second line.
    pub fn open(source: &Source, name: String, topic: &str) -> Result<Self, JsError> {
        let topic = Some(topic.to_owned()).filter(|topic| !topic.is_empty());
        let options = LogOptions { topic, ..LogOptions::default() };
        Ok(Self::read(Bytes::of(source), name, &options)?)
    }

    /// What `dpn check --json` prints.
    pub fn check(&self) -> String {
        self.check.clone()
    }

    /// What was taken for granted and what is to be known of the log, a line each.
    pub fn told(&self) -> String {
        self.told.clone()
    }

    /// A configuration that is held against the log from now on; no bytes for none.
    ///
    /// # Errors
    /// A sentence where it cannot be read.
    pub fn configure(&mut self, name: String, bytes: Vec<u8>) -> Result<(), JsError> {
        self.config = None;
        if !bytes.is_empty() {
            self.configuration(&name, &bytes)?;
            self.config = Some((name, bytes));
        }
        Ok(())
    }

    /// What `dpn noise --json` prints, and behind it, on a line of its own, the picture.
    ///
    /// # Errors
    /// A sentence, and a remedy on a second line.
    pub fn noise(&self) -> Result<String, JsError> {
        Ok(self.along(&progress)?)
    }

    /// What `dpn allan --json` prints, and on a line of its own what else is shown: more formats, and what a configuration is told.
    ///
    /// # Errors
    /// A sentence, and a remedy on a second line.
    pub fn allan(&self) -> Result<String, JsError> {
        Ok(self.at_rest()?)
    }
}

impl Session {
    fn read(source: impl std::io::Read, name: String, options: &LogOptions) -> Result<Self, Failure> {
        let log = read_stream(source, Path::new(&name), options)?;
        let check = serde_json::to_string(&examine_log(&log)?)? + "\n";
        let told = serde_json::json!({
            "kind": log.kind.name(), "topic": log.topic, "guesses": log.guesses, "warnings": log.warnings(),
        });
        let recording = log.recording.held()?;
        Ok(Self { name, recording, check, told: told.to_string(), config: None })
    }

    fn configuration(&self, name: &str, bytes: &[u8]) -> Result<NoiseCalibration, Failure> {
        let rate = Some(self.recording.rate());
        let given = Given { rate, rate_of_log: true, keep_zeros: true, ..Given::default() };
        Ok(parse(bytes, Path::new(name), None, &given)?)
    }

    fn configured(&self) -> Result<Option<NoiseCalibration>, Failure> {
        self.config.as_ref().map(|(name, bytes)| self.configuration(name, bytes)).transpose()
    }

    fn along(&self, watch: &(dyn Fn(f64) + Sync)) -> Result<String, Failure> {
        let networks = NETWORKS.map(|(name, bytes)| Network::from_bytes(bytes, Path::new(name)));
        let networks = networks.into_iter().collect::<Result<Vec<_>, _>>()?;
        let config = self.configured()?;
        let (plan, note) = Plan::fitting(self.recording.rate(), EVERY, &networks)?;
        let along = Along::watched(&plan, &self.recording, config.as_ref(), watch)?;
        let mut picture = picture::of(&along, self.recording.span()[0])?;
        picture["formats"] = along.effective.as_ref().map_or_else(
            || serde_json::json!([]),
            |effective| serde_json::json!(effective.paste.written(&MORE)),
        );
        picture["note"] = serde_json::json!(note);
        picture["start_ns"] = serde_json::json!(self.recording.span()[0].ns().to_string());
        if let (Some(config), Some(check)) = (&config, &along.check) {
            picture["check"] = serde_json::json!({
                "format": config.format, "levels": check.levels.to_string(), "findings": check.findings(), "walks_by": check.walks_by,
                "remarks": config.remarks,
            });
        }
        let json = along.json(&self.name, &plan, &self.recording)?;
        Ok(format!("{json}\n{picture}\n"))
    }

    fn at_rest(&self) -> Result<String, Failure> {
        let config = self.configured()?;
        let allan = AllanLog::of(&self.recording, false)?;
        let findings = config.map(|config| compare(&config, &allan));
        let json = report::json(&allan, findings.as_deref())?;
        let figures = allan.figures();
        let more = MORE
            .map(|format| write(&figures, format, |_| None))
            .into_iter()
            .collect::<Result<Vec<_>, _>>()?;
        let check: Vec<Finding> = findings.iter().flatten().map(FigureCheck::finding).collect();
        let shown = serde_json::json!({ "formats": more, "check": check });
        Ok(format!("{json}\n{shown}\n"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_recorded_log_has_findings_a_track_and_what_the_configuration_is_told() {
        let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("../golden/logs/px4.ulg");
        let file = std::fs::File::open(log).unwrap();
        let mut session = Session::read(file, "px4.ulg".into(), &LogOptions::default()).unwrap();
        assert!(session.check.contains("\"findings\""));
        session.config =
            Some(("vins.yaml".into(), b"acc_n: 0.1\ngyr_n: 0.01\nacc_w: 0.001\ngyr_w: 0.0001\n".into()));
        match session.along(&|_| ()) {
            Ok(text) => assert_eq!(text.lines().count(), 2),
            Err(failure) => assert!(format!("{failure:?}").contains("first window"), "{failure:?}"),
        }
    }

    #[test]
    fn bytes_that_are_no_log_are_a_failure_and_no_panic() {
        for bytes in [&b""[..], b"\0", b"#ROSBAG V2.0\n", b"SQLite format 3\0", &[0xff; 4096]] {
            assert!(Session::read(bytes, "x".into(), &LogOptions::default()).is_err());
        }
    }
}
