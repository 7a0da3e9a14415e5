//! What `dpn simulate tracks` and `dpn simulate images` make their data along: a recording's ground truth, or a flight's exact path.

use crate::args::AlongArgs;
use crate::ui::{Fault, refuse};
use anyhow::Result;
use dpn_core::{SampleRate, Stamp};
use dpn_eval::closed_loop::path_config;
use dpn_io::asl::Sequence;
use dpn_sim::render::SharedPath;
use dpn_sim::tracks::{AnalyticPath, CameraSettings, PathConfig, RecordedPath, camera_stamps};
use dpn_sim::{Flight, FlightConfig};
use std::path::Path;
use std::sync::Arc;

/// Rate of a camera that is not there \[Hz\]: EuRoC's.
const CAMERA_HZ: f64 = 20.0;
/// A faster one is a slip in its calibration \[Hz\].
const FASTEST_CAMERA_HZ: f64 = 1000.0;

/// A path with a camera's stamps on it.
pub(super) struct Along {
    pub(super) name: String,
    pub(super) path: SharedPath,
    pub(super) stamps: Vec<Stamp>,
    pub(super) rate: SampleRate,
    pub(super) of: Source,
}

/// Whose path it is.
pub(super) enum Source {
    Recorded(Box<Sequence>),
    Flown(Flight),
}

/// A folder is a sequence, anything else a flight. `what` is made, by the configuration's `path` and `camera`, which becomes the sequence's own where
/// it names none.
pub(super) fn open(
    args: &AlongArgs,
    what: &str,
    config: &PathConfig,
    camera: &mut Option<CameraSettings>,
) -> Result<Along> {
    let (dir, truth) = (Path::new(&args.source), args.truth.as_deref());
    if dir.exists() {
        let sequence = Sequence::open(dir)?;
        let sequence = match truth {
            Some(truth) => sequence.with_reconciled_truth(truth),
            None => sequence,
        };
        return recorded(sequence, what, config, camera);
    }
    let flight: Flight = args.source.parse().map_err(|unknown| {
        Fault::new(format!("there is no folder `{}`, and {unknown}", args.source))
            .hint("name a folder with an ASL sequence, or a flight of `dpn simulate flight --list`")
    })?;
    if truth.is_some() {
        let text = "--truth is for a recording; a flight's ground truth is exact";
        return refuse(text, "leave --truth away");
    }
    let flown = FlightConfig::default();
    let path = AnalyticPath::new(dpn_sim::path(flight, 0, &flown)?, Stamp::from_ns(flown.epoch_ns));
    let rate = camera_rate(CAMERA_HZ)?;
    let stamps = camera_stamps(&path, rate);
    Ok(Along {
        name: flight.name().to_owned(),
        path: Arc::new(path),
        stamps,
        rate,
        of: Source::Flown(flight),
    })
}

/// The sequence's own camera and stamps where it has them.
fn recorded(
    sequence: Sequence,
    what: &str,
    config: &PathConfig,
    camera: &mut Option<CameraSettings>,
) -> Result<Along> {
    if sequence.ground_truth_path().is_none() {
        return Err(no_ground_truth(sequence.dir(), &format!("{what} are made along true poses")).into());
    }
    let path = RecordedPath::new(&sequence.ground_truth()?, &path_config(&sequence, config))?;
    let own = sequence.camera_config()?;
    if let (None, Some(own)) = (&camera, &own) {
        let settings = CameraSettings::try_from(own).map_err(|e| {
            Fault::new(format!("{}: {e}", sequence.dir().display())).hint(format!(
                "or give the camera to simulate as `[camera]` in a file: configs/{what}/euroc.toml"
            ))
        })?;
        *camera = Some(settings);
    }
    let rate = camera_rate(own.map_or(CAMERA_HZ, |camera| camera.rate.hz()))?;
    let stamps = if sequence.has_camera_frames() {
        sequence.camera_frames()?.iter().map(|frame| frame.t).collect()
    } else {
        camera_stamps(&path, rate)
    };
    let (name, path) = (sequence.name().to_owned(), Arc::new(path));
    Ok(Along { name, path, stamps, rate, of: Source::Recorded(Box::new(sequence)) })
}

/// A sequence that nothing can be made along; `why` it would have to be there.
pub(super) fn no_ground_truth(dir: &Path, why: &str) -> Fault {
    let looked = "state_groundtruth_estimate0/data.csv and mocap0/data.csv are not there";
    Fault::new(format!("{}: no ground truth: {looked}", dir.display()))
        .hint(format!("{why}; without them only real images can be tracked"))
}

fn camera_rate(hz: f64) -> Result<SampleRate, Fault> {
    let rate = SampleRate::from_hz(hz).filter(|rate| rate.hz() <= FASTEST_CAMERA_HZ);
    rate.ok_or_else(|| Fault::new(format!("a camera of {hz} Hz; at most {FASTEST_CAMERA_HZ} are made")))
}
