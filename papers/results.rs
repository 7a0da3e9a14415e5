//! Every stage's results: read where they are there, made where they are not.

use super::cache::cached;
use super::error::{PaperError, stopped};
use super::id::{id, json};
use super::injected::{Response, responses};
use super::paper::Paper;
use super::plan::Plan;
use super::specs;
use cpu_time::ThreadTime;
use dpn_core::Sensor;
use dpn_core::estimate::NoiseSpec;
use dpn_core::progress::Progress;
use dpn_core::random::Stream;
use dpn_eval::closed_loop::{CellFiles, Manifest, Row, SequenceSet, Sweep, UntrackedSequence};
use dpn_eval::injected::{Course, Injection};
use dpn_eval::noise::{Fresh, Recorded, content};
use dpn_eval::open_loop::{self, Request};
use dpn_io::{FolderLock, IoError};
use dpn_pronet::DualProNet;
use dpn_train::base::Base;
use dpn_train::split::Side;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// What a stage left, and where.
#[derive(Debug)]
pub(super) struct StageResult<T> {
    pub(super) value: T,
    /// Name of its folder.
    pub(super) run: String,
    /// Whether nothing had to be made.
    pub(super) cached: bool,
}

/// One closed loop: a folder.
struct SweepRequest<'a> {
    /// What its folder's name begins with.
    name: String,
    source: &'a SequenceSet,
    places: Vec<usize>,
    /// Noises, and with how many seeds.
    noises: (&'a [String], u64),
    /// More noises, and with how many.
    others: (&'a [String], u64),
    injection: Option<Injection>,
    keep: CellFiles,
}

impl Paper<'_> {
    /// What the judged networks are: a checksum of their weights, cards and tags, wherever they lie.
    pub(super) fn networks_id(&self) -> Result<String, PaperError> {
        let mut parts = Vec::new();
        for network in self.judged {
            parts.push(network.tag().into_bytes());
            parts.push(network.weights.to_bytes()?);
        }
        Ok(id(parts))
    }

    /// The rows of the open loop.
    pub(super) fn open_loop(
        &self,
        networks: &str,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<StageResult<Vec<open_loop::Row>>, PaperError> {
        let mut parts = vec![self.measured_by(), networks.to_owned(), self.plan.seed.to_string()];
        parts.push(self.plan.bases.join(";"));
        parts.extend([self.input.corpus.name.clone(), self.input.corpus.fingerprint()]);
        let run = format!("open-loop-{}", id(&parts));
        let bases: Vec<Base> = self.plan.bases.iter().map(|base| base.parse()).collect::<Result<_, _>>()?;
        let program = self.measured_by();
        let cells = self.work.join(&run).join("cells");
        let (value, cached) = self.cached(&run, &self.work.join(&run).join("rows.json"), || {
            let request = Request {
                corpora: std::slice::from_ref(&self.input.corpus),
                sensors: &Sensor::ALL,
                bases: &bases,
                networks: self.judged,
                seed: self.plan.seed,
                drawn: None,
                program: &program,
            };
            Ok(open_loop::run(&request, &cells, stop, progress)?.rows)
        })?;
        // They served to go on with; the rows are whole now.
        match std::fs::remove_dir_all(&cells) {
            Err(source) if source.kind() != std::io::ErrorKind::NotFound => {
                return Err(IoError::Write { path: cells, source }.into());
            }
            _ => {}
        }
        Ok(StageResult { value, run, cached })
    }

    /// What the study's sweep keeps of runs for the figures.
    pub(super) fn keep(&self) -> CellFiles {
        let noises = specs::noises([specs::BASELINE, specs::DUALPRONET]).to_vec();
        CellFiles { states: Some((noises, self.plan.seed)), ..CellFiles::default() }
    }

    /// The study.
    fn study(&self) -> SweepRequest<'_> {
        SweepRequest {
            name: "closed-loop".into(),
            source: &self.input.source,
            places: self.input.places.clone(),
            noises: (&self.plan.noises, self.plan.seeds),
            others: (&self.plan.others, self.plan.other_seeds),
            injection: None,
            keep: self.keep(),
        }
    }

    /// One course of the injected experiment.
    fn experiment(&self, course: Course) -> SweepRequest<'_> {
        let plan = &self.plan.injected;
        let (noises, seeds) = match course {
            Course::Step => (&plan.noises, plan.seeds),
            _ => (&plan.followed, plan.course_seeds),
        };
        SweepRequest {
            name: format!("injected-{course}"),
            source: &self.input.injected,
            places: self.injected_places(),
            noises: (noises, seeds),
            others: (&[], 0),
            injection: Some(plan.noise.with(course)),
            keep: CellFiles::default(),
        }
    }

    /// Every closed loop of the paper: the name of its folder, the runs, and what they are made from. Nothing is run.
    ///
    /// # Errors
    /// Data that cannot be read; noises that are none.
    pub fn sweeps(&self) -> Result<Vec<(String, Sweep<'_>, Manifest)>, PaperError> {
        let courses = self.plan.injected.courses.iter().map(|course| self.experiment(*course));
        let requests = std::iter::once(self.study()).chain(courses);
        requests.map(|request| self.sweep_of(&request)).collect()
    }

    /// The rows of the study, and the sequences that cannot be seen.
    pub(super) fn closed_loop(
        &self,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<(StageResult<Vec<Row>>, Vec<UntrackedSequence>), PaperError> {
        self.sweep(&self.study(), stop, progress)
    }

    /// The rows of one course of the injected experiment.
    pub(super) fn injected(
        &self,
        course: Course,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<StageResult<Vec<Row>>, PaperError> {
        // Every sequence was seen in the closed loop or left out; one that is not seen now has no row here either.
        let (made, unseen) = self.sweep(&self.experiment(course), stop, progress)?;
        match unseen.into_iter().next() {
            Some(unseen) => Err(unseen.error.into()),
            None => Ok(made),
        }
    }

    /// The first sequences of both sides, as many of each as can be.
    pub(super) fn injected_places(&self) -> Vec<usize> {
        let names = self.input.source.names();
        let most = match self.plan.injected.most_sequences {
            0 => usize::MAX,
            most => most,
        };
        let (train, test): (Vec<usize>, Vec<usize>) =
            self.input.places.iter().partition(|place| names[**place].1 == Side::Train);
        let tests = test.len().min(most.saturating_sub(train.len()).max(most / 2));
        let mut places: Vec<usize> = train.into_iter().take(most.saturating_sub(tests)).collect();
        places.extend(test.into_iter().take(tests));
        places.sort_unstable();
        places
    }

    /// The runs of a loop, the name of their folder, and what they are made from.
    fn sweep_of<'a>(
        &'a self,
        wanted: &SweepRequest<'a>,
    ) -> Result<(String, Sweep<'a>, Manifest), PaperError> {
        // One seed where nothing depends on it.
        let seeded = wanted.source.tracks_are_seeded() || wanted.source.recordings_are_seeded();
        let first = self.plan.seed;
        let seeds = |count: u64| (first..first + if seeded { count } else { count.min(1) }).collect();
        let sweep = Sweep {
            source: wanted.source,
            places: wanted.places.clone(),
            noises: Plan::parsed(wanted.noises.0)?,
            seeds: seeds(wanted.noises.1),
            others: (Plan::parsed(wanted.others.0)?, seeds(wanted.others.1)),
            from: self.from,
            to: None,
            estimator: self.estimator.clone(),
            networks: self.networks,
            threads: self.threads,
            cache: self.cache,
            keep: wanted.keep.clone(),
            injection: wanted.injection,
        };
        let manifest = Manifest::of(&sweep, self.measured_by())?;
        let run = format!("{}-{}", wanted.name, &manifest.fingerprint()[..16]);
        Ok((run, sweep, manifest))
    }

    /// All runs of a loop.
    fn sweep(
        &self,
        wanted: &SweepRequest<'_>,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<(StageResult<Vec<Row>>, Vec<UntrackedSequence>), PaperError> {
        let (run, sweep, manifest) = self.sweep_of(wanted)?;
        let lock = FolderLock::take(&self.work.join(&run))?;
        if let Some(program) = self.measured_by {
            let left = sweep.left(&lock, &manifest)?;
            if left > 0 {
                let what = format!("{left} runs of {run}");
                return Err(PaperError::NotMeasured { what, program: program.to_owned() });
            }
        }
        let mut watch = StepWatch { inner: progress, stepped: false };
        let (value, unseen) = sweep.run_what_can_be_tracked(&lock, &manifest, stop, &mut watch)?;
        Ok((StageResult { value, run, cached: !watch.stepped }, unseen))
    }

    /// The program whose runs are taken.
    fn measured_by(&self) -> String {
        self.measured_by.unwrap_or(&self.program).to_owned()
    }

    /// What lies at `path`, or is made and put there; not made where another program's runs are taken.
    fn cached<T: Serialize + DeserializeOwned>(
        &self,
        run: &str,
        path: &Path,
        make: impl FnOnce() -> Result<T, PaperError>,
    ) -> Result<(T, bool), PaperError> {
        match self.measured_by {
            Some(program) if !path.exists() => {
                Err(PaperError::NotMeasured { what: run.to_owned(), program: program.to_owned() })
            }
            _ => cached(path, make),
        }
    }

    /// How noises follow what is injected.
    pub(super) fn responses(&self, stop: &AtomicBool) -> Result<StageResult<Vec<Response>>, PaperError> {
        let plan = &self.plan.injected;
        let places = self.injected_places();
        let mut noises = Plan::parsed(&plan.followed)?;
        noises.retain(|noise| !specs::is_of_run(noise));
        let mut parts = vec![self.measured_by(), self.plan.seed.to_string(), json(&plan.noise)];
        parts.push(json(&self.input.source.description()));
        parts.extend(self.contents(&noises)?);
        parts.extend(self.checksums(&places)?);
        let run = format!("response-{}", id(&parts));
        let dir = self.work.join(&run);
        let (value, cached) = self.cached(&run, &dir.join("responses.json"), || {
            let injected = (&plan.noise, self.plan.seed);
            responses(
                &self.input.source,
                &places,
                &noises,
                self.networks,
                injected,
                &dir.join("pieces"),
                stop,
            )
        })?;
        Ok(StageResult { value, run, cached })
    }

    /// Every noise, as it is called and as what it is made of: a file may be another under its old name.
    fn contents(&self, noises: &[NoiseSpec]) -> Result<Vec<String>, PaperError> {
        let of = |noise: &NoiseSpec| Ok([noise.to_string(), content(noise, self.networks)?]);
        Ok(noises.iter().map(of).collect::<Result<Vec<_>, PaperError>>()?.concat())
    }

    /// Checksums of the sequences at `places`.
    pub(super) fn checksums(&self, places: &[usize]) -> Result<Vec<String>, PaperError> {
        Ok(places.iter().map(|place| self.input.source.checksum(*place)).collect::<Result<_, _>>()?)
    }

    /// CPU time of six windows of every noise of the study \[ms\], on the first sequence.
    pub(super) fn model_times(
        &self,
        stop: &AtomicBool,
    ) -> Result<StageResult<Vec<(NoiseSpec, f64)>>, PaperError> {
        let mut noises = Plan::parsed(self.plan.noises.iter().chain(&self.plan.others))?;
        noises.retain(|noise| !noise.needs_training() && !specs::is_of_run(noise));
        let place = self.input.places[0];
        let mut parts = vec![self.measured_by(), self.plan.seed.to_string()];
        parts.push(json(&self.input.source.description()));
        parts.extend(self.contents(&noises)?);
        parts.extend(self.checksums(&[place])?);
        let run = format!("timing-{}", id(&parts));
        let (value, cached) = self.cached(&run, &self.work.join(&run).join("windows.json"), || {
            stopped(stop)?;
            let recording = self.input.source.recording(place, self.plan.seed)?;
            let recorded =
                Recorded { name: &recording.name, imu: &recording.imu, oracle: recording.oracle.as_ref() };
            let sources = Fresh { recorded, networks: self.networks };
            let answers = recording.imu.len() as f64 / DualProNet::HOP as f64;
            let mut times = Vec::new();
            for noise in noises {
                stopped(stop)?;
                let clock = ThreadTime::now();
                dpn_eval::noise::track(&noise, &recording.imu, &sources, &Stream::new(self.plan.seed))?;
                times.push((noise, 1e3 * clock.elapsed().as_secs_f64() / answers));
            }
            Ok(times)
        })?;
        Ok(StageResult { value, run, cached })
    }
}

/// Passes progress on and remembers whether there was any: whether something had to be made.
struct StepWatch<'a> {
    inner: &'a mut dyn Progress,
    stepped: bool,
}

impl Progress for StepWatch<'_> {
    fn start(&mut self, what: &str, total: u64) {
        self.inner.start(what, total);
    }

    fn step(&mut self, done: u64, note: &str) {
        self.stepped = true;
        self.inner.step(done, note);
    }

    fn finish(&mut self, note: &str) {
        self.inner.finish(note);
    }
}
