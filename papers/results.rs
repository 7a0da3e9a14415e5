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
use dpn_eval::closed_loop::{Camera, CellFiles, Experiment, Row, SequenceSet, UntrackedSequence};
use dpn_eval::injected::Course;
use dpn_eval::noise::{Fresh, Recorded, content};
use dpn_eval::open_loop::{self, Request};
use dpn_eval::sweeps::LoopJob;
use dpn_io::{FolderLock, ResultPath};
use dpn_pronet::DualProNet;
use dpn_train::base::Base;
use dpn_train::split::Side;
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeSet;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Folder of what an open loop under way is made of.
const CELLS: &str = "cells";

/// What a stage left, and where.
#[derive(Debug)]
pub(super) struct StageResult<T> {
    pub(super) value: T,
    /// Name of its folder.
    pub(super) run: String,
    /// Whether nothing had to be made.
    pub(super) cached: bool,
}

/// One closed loop: what its folder's name begins with, what is run, and over which sequences.
pub(super) struct PaperLoop<'a> {
    name: String,
    pub(super) experiment: Experiment,
    pub(super) source: &'a SequenceSet,
    /// How many sequences.
    pub(super) count: usize,
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
        let bases: Vec<Base> = self.plan.bases.iter().map(|base| base.parse()).collect::<Result<_, _>>()?;
        let program = self.measured_by();
        let made = self.stage("open-loop", "rows.json", &parts, |dir| {
            let request = Request {
                corpora: std::slice::from_ref(&self.input.corpus),
                sensors: &Sensor::ALL,
                bases: &bases,
                networks: self.judged,
                seed: self.plan.seed,
                program: &program,
            };
            Ok(open_loop::run(&request, &dir.join(CELLS), stop, progress)?)
        })?;
        let cells = self.work.join(&made.run).join(CELLS);
        // They served to go on with; the rows are whole now.
        cells.remove_all()?;
        Ok(made)
    }

    /// What the study's sweep keeps of runs for the figures.
    pub(super) fn keep(&self) -> CellFiles {
        CellFiles { states: Some((self.states(), self.plan.seed)), ..CellFiles::default() }
    }

    fn states(&self) -> Vec<NoiseSpec> {
        specs::noises([specs::BASELINE, specs::DUALPRONET]).to_vec()
    }

    /// The study.
    fn study(&self) -> Result<PaperLoop<'_>, PaperError> {
        let (plan, source) = (self.plan, &self.input.source);
        let experiment = Experiment {
            noises: Plan::parsed(&plan.noises)?,
            seeds: plan.seeds,
            others: Plan::parsed(&plan.others)?,
            other_seeds: plan.other_seeds,
            states: self.states(),
            ..self.run.clone()
        };
        Ok(self.closed("closed-loop".into(), experiment, source, &self.input.places))
    }

    /// One course of the injected experiment.
    fn experiment(&self, course: Course) -> Result<PaperLoop<'_>, PaperError> {
        let plan = &self.plan.injected;
        let (noises, seeds) = match course {
            Course::Step => (&plan.noises, plan.seeds),
            _ => (&plan.followed, plan.course_seeds),
        };
        let experiment = Experiment {
            // Rendered images would take long.
            camera: if self.run.camera == Camera::Rendered { Camera::Tracks } else { self.run.camera },
            noises: Plan::parsed(noises)?,
            seeds,
            injection: Some(plan.noise.with(course).into()),
            ..self.run.clone()
        };
        let places = self.injected_places();
        Ok(self.closed(format!("injected-{course}"), experiment, &self.input.injected, &places))
    }

    fn closed<'a>(
        &self,
        name: String,
        mut experiment: Experiment,
        source: &'a SequenceSet,
        places: &[usize],
    ) -> PaperLoop<'a> {
        let names = source.names();
        experiment.sequences =
            places.iter().map(|place| names[*place].0.as_str()).collect::<Vec<_>>().join(",");
        experiment.seed = self.plan.seed;
        // One seed where nothing depends on it.
        if !source.tracks_are_seeded() && !source.recordings_are_seeded() {
            (experiment.seeds, experiment.other_seeds) = (1, 1);
        }
        PaperLoop { name, experiment, source, count: places.len() }
    }

    /// Every closed loop of the paper. Nothing is run.
    ///
    /// # Errors
    /// Data that cannot be read; noises that are none.
    pub fn loops(&self) -> Result<Vec<LoopJob<'_>>, PaperError> {
        self.requests().map(|closed| self.job(closed?)).collect()
    }

    /// The study, then every course.
    pub(super) fn requests(&self) -> impl Iterator<Item = Result<PaperLoop<'_>, PaperError>> {
        let courses = self.plan.injected.courses.iter().map(|course| self.experiment(*course));
        std::iter::once(self.study()).chain(courses)
    }

    /// The rows of the study, and the sequences that cannot be seen.
    pub(super) fn closed_loop(
        &self,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<(StageResult<Vec<Row>>, Vec<UntrackedSequence>), PaperError> {
        self.sweep(self.study()?, stop, progress)
    }

    /// The rows of one course of the injected experiment.
    pub(super) fn injected(
        &self,
        course: Course,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<StageResult<Vec<Row>>, PaperError> {
        // Every sequence was seen in the closed loop or left out; one that is not seen now has no row here either.
        let (made, unseen) = self.sweep(self.experiment(course)?, stop, progress)?;
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

    /// The runs of a loop, the folder of their results, and what they are made from.
    fn job<'a>(&self, wanted: PaperLoop<'a>) -> Result<LoopJob<'a>, PaperError>
    where
        Self: 'a,
    {
        let PaperLoop { name, experiment, source, .. } = wanted;
        let mut job = LoopJob::new(PathBuf::new(), experiment, source, self.networks, self.measured_by())?;
        (job.sweep.threads, job.sweep.cache) = (self.threads, self.cache);
        job.folder = format!("{name}-{}", &job.made_from.fingerprint()[..16]).into();
        Ok(job)
    }

    /// What is to be said of the settings of all closed loops.
    ///
    /// # Errors
    /// Noises that are none.
    pub fn warnings(&self) -> Result<BTreeSet<String>, PaperError> {
        let mut all = BTreeSet::new();
        for closed in self.requests() {
            all.extend(closed?.experiment.warnings()?);
        }
        Ok(all)
    }

    /// All runs of a loop.
    fn sweep(
        &self,
        wanted: PaperLoop<'_>,
        stop: &AtomicBool,
        progress: &mut dyn Progress,
    ) -> Result<(StageResult<Vec<Row>>, Vec<UntrackedSequence>), PaperError> {
        let LoopJob { folder, sweep, made_from: manifest, .. } = self.job(wanted)?;
        let run = folder.display().to_string();
        let lock = FolderLock::take(self.work.join(&run))?;
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

    /// A stage that is no sweep: it lies in `file` of a folder named by its `parts`, or is made and put there; not made where another program's runs are taken.
    fn stage<T: Serialize + DeserializeOwned>(
        &self,
        kind: &str,
        file: &str,
        parts: &[String],
        make: impl FnOnce(&ResultPath) -> Result<T, PaperError>,
    ) -> Result<StageResult<T>, PaperError> {
        let run = format!("{kind}-{}", id(parts));
        let dir = self.work.join(&run);
        let path = dir.join(file);
        match self.measured_by {
            Some(program) if !path.is_file() => {
                Err(PaperError::NotMeasured { what: run, program: program.to_owned() })
            }
            _ => {
                let (value, cached) = cached(&path, || make(&dir))?;
                Ok(StageResult { value, run, cached })
            }
        }
    }

    /// What `noises` told on the sequences at `places` depend on.
    fn told_by(&self, noises: &[NoiseSpec], places: &[usize]) -> Result<Vec<String>, PaperError> {
        // Every noise as it is called and as what it is made of: a file may be another under its old name.
        let of = |noise: &NoiseSpec| Ok([noise.to_string(), content(noise, self.networks)?]);
        let mut parts = vec![json(&self.input.source.description())];
        parts.extend(noises.iter().map(of).collect::<Result<Vec<_>, PaperError>>()?.concat());
        parts.extend(self.checksums(places)?);
        Ok(parts)
    }

    /// How noises follow what is injected.
    pub(super) fn responses(&self, stop: &AtomicBool) -> Result<StageResult<Vec<Response>>, PaperError> {
        let plan = &self.plan.injected;
        let places = self.injected_places();
        let mut noises = Plan::parsed(&plan.followed)?;
        noises.retain(|noise| !specs::is_of_run(noise));
        let mut parts = vec![self.measured_by(), self.plan.seed.to_string(), json(&plan.noise)];
        parts.extend(self.told_by(&noises, &places)?);
        self.stage("response", "responses.json", &parts, |dir| {
            let (source, injected) = (&self.input.source, (&plan.noise, self.plan.seed));
            responses(source, &places, &noises, self.networks, injected, &dir.join("pieces"), stop)
        })
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
        parts.extend(self.told_by(&noises, &[place])?);
        self.stage("timing", "windows.json", &parts, |_| {
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
        })
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
