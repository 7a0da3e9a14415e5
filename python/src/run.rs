//! The odometry: what `dpn run` calls, on what it reads or on arrays.

use crate::error::{Error, raise, word};
use crate::metrics::poses;
use crate::progress::Listener;
use crate::recording::Recording as Samples;
use crate::run_result::RunResult;
use dpn_core::camera::CameraModel;
use dpn_core::estimate::NoiseSpec;
use dpn_core::{Stamp, Track, TrackFrame};
use dpn_eval::closed_loop::{
    Camera, CameraInput, JudgedRun, Recording, RunInfo, RunSource, Span, StartAt, TruthKind, Watchers,
    watched_run,
};
use dpn_io::calibration::{self, Calibration};
use dpn_io::config::load_over;
use dpn_logs::{ImageLogOptions, LogOptions};
use dpn_pronet::network::{Network, load_all};
use dpn_train::split::Side;
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::Update;
use dpn_vio::window::Window;
use nalgebra::Vector2;
use numpy::{PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};

/// What every run is told, as `dpn.run` hands it on.
#[derive(FromPyObject)]
#[pyo3(from_item_all)]
pub(crate) struct Asked {
    noise: String,
    /// File of the estimator's settings, and keys over it.
    config: Option<PathBuf>,
    sets: Vec<(String, String)>,
    /// File of a calibration, or one as JSON.
    calibration: Option<PathBuf>,
    calibration_json: Option<String>,
    models: Option<PathBuf>,
    seed: u64,
    start: String,
    end: Option<f64>,
    progress: Option<Py<PyAny>>,
}

/// The same, read and checked.
pub(crate) struct Settings {
    pub(crate) noise: NoiseSpec,
    pub(crate) estimator: EstimatorConfig,
    pub(crate) calibration: Option<Calibration>,
    pub(crate) networks: Vec<Network>,
    pub(crate) seed: u64,
    start: StartAt,
    end: Option<f64>,
    listener: Listener,
}

impl Asked {
    pub(crate) fn read(self) -> PyResult<Settings> {
        let calibration = match (&self.calibration, &self.calibration_json) {
            (Some(path), _) => Some(calibration::read(path).map_err(|e| raise(&e))?),
            (None, Some(json)) => {
                let name = Path::new("calibration");
                Some(calibration::parse(json.as_bytes(), name).map_err(|e| raise(&e))?)
            }
            (None, None) => None,
        };
        let networks = match &self.models {
            Some(dir) => load_all(dir),
            None => dpn_program::shipped(),
        };
        Ok(Settings {
            noise: self.noise.parse().map_err(|e| Error::new_err(format!("noise: {e}")))?,
            estimator: load_over(self.config.as_deref(), &self.sets).map_err(|e| raise(&e))?,
            calibration,
            networks: networks.map_err(|e| raise(&e))?,
            seed: self.seed,
            start: self.start.parse().map_err(|e| Error::new_err(format!("start: {e}")))?,
            end: self.end,
            listener: Listener::new(self.progress),
        })
    }
}

impl Settings {
    fn span(&self, name: &str) -> Span {
        Span { from_s: self.start.seconds(name), to_s: self.end }
    }

    fn run(
        &mut self,
        recording: &Recording,
        camera: CameraInput<'_>,
        (seen_by, truth): (&str, TruthKind),
    ) -> PyResult<JudgedRun> {
        let span = self.span(&recording.name);
        let info = RunInfo {
            camera: seen_by.into(),
            truth,
            noise: self.noise.clone(),
            seed: self.seed,
            from_s: span.from_s,
            to_s: span.to_s,
            front_end: None,
        };
        let last = recording.imu.samples().last().expect("a recording has two samples").t;
        let (listener, mut first) = (&mut self.listener, None);
        let mut watch = |update: &Update, _: &Window| {
            let first = *first.get_or_insert(update.t);
            let total = last.seconds_since(first);
            let total = span.to_s.map_or(total, |to_s| total.min(to_s - span.from_s));
            listener.step(update.t.seconds_since(first).min(total), total)
        };
        let watchers = Watchers { images: &mut (), updates: &mut watch };
        watched_run(&self.estimator, recording, camera, &self.noise, info, &self.networks, watchers)
            .map_err(|e| raise(&e))
    }

    /// The exception that ended the run, else what came of it.
    fn finish(self, done: PyResult<RunResult>) -> PyResult<RunResult> {
        self.listener.or(done)
    }
}

/// Of a folder, a log with images or a flight.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn run_source(
    py: Python<'_>,
    asked: Asked,
    source: String,
    camera: Option<&str>,
    tracks: Option<PathBuf>,
    truth: Option<PathBuf>,
    skip_missing: bool,
    topic: Option<String>,
    image_topic: Option<String>,
) -> PyResult<RunResult> {
    let camera: Option<Camera> = word("camera", camera)?;
    py.detach(|| {
        let mut settings = asked.read()?;
        let log =
            ImageLogOptions { imu: LogOptions { topic, ..LogOptions::default() }, image_topic, skip_missing };
        let how = RunSource { camera, tracks, truth, log, ..RunSource::default() };
        let opened = how.with_calibration(settings.calibration.clone()).and_then(|how| how.one(&source));
        let (set, place) = opened.map_err(|e| raise(&e))?;
        let recording = set.recording(place, settings.seed).map_err(|e| raise(&e))?;
        let span = settings.span(&recording.name);
        let camera = set.camera_input(place, settings.seed, &span).map_err(|e| raise(&e))?;
        let done = settings.run(&recording, camera, (set.camera(), set.truth())).and_then(|done| {
            let input = set.checksum(place).map_err(|e| raise(&e))?;
            let origin = (set.tracks.is_simulated(), set.truth());
            Ok(RunResult::new(
                done.json(&dpn_program::program(), &settings.estimator, Some(&input), origin),
                &settings.estimator,
                done,
            ))
        });
        settings.finish(done)
    })
}

/// Of samples and tracks at hand: a stamp `(m,)` of the frame, an id `(m,)` and a pixel `(m, 2)` an observation, in increasing time.
#[pyfunction]
#[allow(clippy::too_many_arguments)]
pub(crate) fn run_arrays(
    py: Python<'_>,
    asked: Asked,
    name: String,
    samples: &Samples,
    frame_t_ns: PyReadonlyArray1<'_, i64>,
    ids: PyReadonlyArray1<'_, u64>,
    px: PyReadonlyArray2<'_, f64>,
    truth: Option<(PyReadonlyArray1<'_, i64>, PyReadonlyArray2<'_, f64>)>,
) -> PyResult<RunResult> {
    let truth = truth.map(|(t_ns, rows)| poses(&t_ns, &rows)).transpose()?;
    let imu = samples.held()?;
    let observed = frame_t_ns.as_slice()?.iter().zip(ids.as_slice()?).zip(px.as_slice()?.as_chunks::<2>().0);
    let mut frames: Vec<TrackFrame> = Vec::new();
    for ((&t_ns, &id), &px) in observed {
        let t = Stamp::from_ns(t_ns);
        if frames.last().is_none_or(|frame| frame.t != t) {
            frames.push(TrackFrame::new(t, Vec::new()));
        }
        let tracks = &mut frames.last_mut().expect("one was just put there").tracks;
        tracks.push(Track { id, px: Vector2::from(px) });
    }
    py.detach(|| {
        let mut settings = asked.read()?;
        let given = settings.calibration.as_ref().expect("Python asks for one");
        frames.iter_mut().for_each(|frame| frame.t = given.on_imu_clock(frame.t));
        let camera = CameraModel::try_from(&given.camera);
        let recording = Recording {
            side: Side::Test,
            imu,
            camera: camera.map_err(|e| Error::new_err(format!("calibration: {e}")))?,
            body_from_cam: given.camera.body_from_cam,
            truth,
            oracle: None,
            remarks: Vec::new(),
            name,
        };
        let camera = CameraInput::Tracks(frames, settings.span(&recording.name));
        let done = settings.run(&recording, camera, ("tracks", TruthKind::Published)).map(|done| {
            let report =
                done.json(&dpn_program::program(), &settings.estimator, None, (false, TruthKind::Published));
            RunResult::new(report, &settings.estimator, done)
        });
        settings.finish(done)
    })
}
