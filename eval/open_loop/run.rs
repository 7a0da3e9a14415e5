//! The open loop: every estimator on every set of windows with known noise.
//!
//! For each sensor, collection and base, the disjoint windows of both sides of the split are injected on the paper's grid
//! and on as many continuous levels. Simple estimators and networks read the noisy windows; regressors are fitted to the
//! training side first. A collection without bases of its own (raw TUM-VI) is judged as it is, by networks and
//! regressors of every base: nothing is ever trained on it.

use super::cells::Cells;
use super::job::{Fitted, Job};
use super::request::{OpenLoopError, Request};
use super::rows::Row;
use dpn_core::Sensor;
use dpn_core::checksum::of_parts;
use dpn_core::estimate::spec::EstimatorSpec;
use dpn_core::estimate::{EstimatorError, WindowSigma};
use dpn_core::progress::Progress;
use dpn_io::ResultPath;
use dpn_pronet::StoreError;
use dpn_train::asl::TUM_VI;
use dpn_train::base::Base;
use dpn_train::corpus::Corpus;
use dpn_train::features::Features;
use dpn_train::levels::LevelKind;
use dpn_train::windows::WINDOW;
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

/// Judges everything asked for. A set of windows that is over is kept in `dir`, and taken from there by a later call with the same input.
///
/// # Errors
/// Filters or estimators that cannot be; too few windows; a folder that cannot be written to; [`OpenLoopError::Stopped`] when `stop` was set.
pub fn run(
    request: &Request<'_>,
    dir: &ResultPath,
    stop: &AtomicBool,
    progress: &mut dyn Progress,
) -> Result<Vec<Row>, OpenLoopError> {
    let (features, simple) = (Features::new()?, simple_estimators()?);
    let job = |(sensor, corpus, base, kind)| Job {
        request,
        sensor,
        corpus,
        base,
        kind,
        features: &features,
        simple: &simple,
        stop,
    };
    let jobs: Vec<Job<'_>> = plan(request).into_iter().map(job).collect();
    let contents = contents(request, &jobs)?;
    let cells = Cells::new(dir);
    let (mut out, mut kept, total) = (Vec::new(), 0, jobs.len());
    progress.start("open loop", total as u64);
    let mut transfer: BTreeMap<(Sensor, &'static str), (usize, Fitted)> = BTreeMap::new();
    for (place, (job, content)) in jobs.iter().zip(&contents).enumerate() {
        let stopped = |error| match error {
            OpenLoopError::Stopped { .. } => OpenLoopError::Stopped { done: place, total },
            error => error,
        };
        let rows = if let Some(rows) = cells.read(content) {
            kept += 1;
            rows
        } else {
            if stop.load(Ordering::Relaxed) {
                return Err(OpenLoopError::Stopped { done: place, total });
            }
            let (sensor, corpus, base, levels) = (job.sensor, job.corpus, job.base, job.kind.family());
            progress.step(place as u64, &format!("{} {sensor} {base} {levels}", corpus.name));
            if job.foreign() {
                refit(&jobs, job, &mut transfer).map_err(stopped)?;
            }
            let foreign = transfer.get(&(sensor, levels)).map(|(_, fitted)| fitted);
            let (rows, fitted) = job.judge(foreign).map_err(stopped)?;
            cells.write(content, &rows)?;
            if let Some(fitted) = fitted {
                transfer.insert((sensor, levels), (place, fitted));
            }
            rows
        };
        out.extend(rows);
    }
    let reused = match kept {
        0 => String::new(),
        kept => format!(": {kept} of {total} sets kept from {}, {} run", dir.display(), total - kept),
    };
    progress.finish(&format!("{} rows{reused}", out.len()));
    Ok(out)
}

/// Makes sure that what is carried over to `foreign` is what was fitted last on windows of its sensor and levels: of sets that were kept nothing is
/// fitted yet.
fn refit(
    jobs: &[Job<'_>],
    foreign: &Job<'_>,
    transfer: &mut BTreeMap<(Sensor, &'static str), (usize, Fitted)>,
) -> Result<(), OpenLoopError> {
    let key = (foreign.sensor, foreign.kind.family());
    for (place, job) in jobs.iter().enumerate().rev() {
        if job.foreign() || (job.sensor, job.kind.family()) != key {
            continue;
        }
        if transfer.get(&key).is_some_and(|(there, _)| *there == place) {
            return Ok(());
        }
        if let Some(fitted) = job.training()?.fitted {
            transfer.insert(key, (place, fitted));
            return Ok(());
        }
    }
    Ok(())
}

/// Checksum of everything that each job's rows are a function of.
fn contents(request: &Request<'_>, jobs: &[Job<'_>]) -> Result<Vec<String>, OpenLoopError> {
    let sums: BTreeMap<&str, String> =
        request.corpora.iter().map(|corpus| (corpus.name.as_str(), corpus.fingerprint())).collect();
    let networks: Result<Vec<(Sensor, String)>, StoreError> =
        request.networks.iter().map(|n| Ok((n.sensor(), of_parts([n.weights.to_bytes()?])))).collect();
    let networks = networks?;
    let own = |job: &Job<'_>| {
        let mut parts = vec![request.program.to_owned(), request.seed.to_string(), job.corpus.name.clone()];
        parts.extend([sums[job.corpus.name.as_str()].clone(), job.sensor.to_string(), job.base.to_string()]);
        parts.push(job.kind.family().to_owned());
        parts.extend(networks.iter().filter(|(sensor, _)| *sensor == job.sensor).map(|(_, sum)| sum.clone()));
        of_parts(parts)
    };
    let all: Vec<String> = jobs.iter().map(own).collect();
    // What nothing is fitted on depends on what is carried over to it: on any of the others.
    let fitted =
        of_parts(jobs.iter().zip(&all).filter(|(job, _)| !job.foreign()).map(|(_, content)| content));
    let whole = |(job, own): (&Job<'_>, String)| if job.foreign() { of_parts([&own, &fitted]) } else { own };
    Ok(jobs.iter().zip(all).map(whole).collect())
}

/// Collections with bases first, so that what is fitted on them can be carried to the raw ones.
fn plan<'a>(request: &Request<'a>) -> Vec<(Sensor, &'a Corpus, Base, LevelKind)> {
    let mut sets = Vec::new();
    for raw in [false, true] {
        for corpus in request.corpora.iter().filter(|corpus| (corpus.name == TUM_VI) == raw) {
            for &sensor in request.sensors {
                let own = [Base::Raw];
                for &base in if raw { &own[..] } else { request.bases } {
                    for kind in [LevelKind::Grid, LevelKind::Uniform] {
                        sets.push((sensor, corpus, base, kind));
                    }
                }
            }
        }
    }
    sets
}

/// The simple estimators of the study, with their default parameters.
fn simple_estimators() -> Result<Vec<Arc<dyn WindowSigma>>, EstimatorError> {
    EstimatorSpec::all().iter().map(|spec| spec.for_windows(WINDOW)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::progress::Silent;
    use dpn_core::random::Stream;
    use dpn_core::{ImuRecording, ImuSample, Stamp};
    use dpn_train::corpus::Member;
    use dpn_train::split::Side;
    use rand::Rng;

    fn corpus(name: &str, seed: u64) -> Corpus {
        let member = |name: &str, side, seed| {
            let mut rng = Stream::new(seed).named("open loop test").rng();
            let samples = (0..1200).map(|i| {
                let mut axes = || [(); 3].map(|()| (0.01 * i as f64).sin() + 0.01 * rng.random::<f64>());
                ImuSample { t: Stamp::from_ns(5_000_000 * i), gyro: axes(), accel: axes() }
            });
            Member { name: name.into(), recording: ImuRecording::new(samples.collect()).unwrap(), side }
        };
        Corpus::new(name, vec![member("a", Side::Train, seed), member("b", Side::Test, seed + 1)]).unwrap()
    }

    /// Stops after so many sets.
    struct StopAt<'a>(u64, &'a AtomicBool);

    impl Progress for StopAt<'_> {
        fn start(&mut self, _: &str, _: u64) {}
        fn step(&mut self, done: u64, _: &str) {
            self.1.store(done >= self.0, Ordering::Relaxed);
        }
        fn finish(&mut self, _: &str) {}
    }

    #[test]
    fn an_open_loop_that_was_stopped_goes_on_to_the_same_rows() {
        let corpora = [corpus("made", 1), corpus(TUM_VI, 3)];
        let bases: Vec<Base> = vec!["sg(5,2)".parse().unwrap(), "sg(11,2)".parse().unwrap()];
        let request = Request {
            corpora: &corpora,
            sensors: &[Sensor::Accel],
            bases: &bases,
            networks: &[],
            seed: 0,
            program: "dpn 1",
        };
        let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        let never = AtomicBool::new(false);
        let expected = run(&request, &whole.path().into(), &never, &mut Silent).unwrap();
        assert!(expected.iter().any(|row| row.estimator == "kernel-svr@sg(11,2)" && row.data == TUM_VI));
        // Four sets with bases, two without: the stop is asked for in the last one.
        let stop = AtomicBool::new(false);
        let stopped = run(&request, &parts.path().into(), &stop, &mut StopAt(5, &stop)).unwrap_err();
        assert!(matches!(stopped, OpenLoopError::Stopped { done: 5, total: 6 }), "{stopped}");
        let files = || std::fs::read_dir(parts.path()).unwrap().count();
        assert_eq!(files(), 5);
        // The regressors of the sets that are kept are fitted again.
        let found = run(&request, &parts.path().into(), &never, &mut Silent).unwrap();
        assert_eq!(found, expected);
        // Another program, seed or recording is another cell.
        for other in [
            Request { program: "dpn 2", ..request_of(&request) },
            Request { seed: 1, ..request_of(&request) },
            Request { corpora: &[corpus("made", 2), corpus(TUM_VI, 3)], ..request_of(&request) },
        ] {
            let stop = AtomicBool::new(true);
            let error = run(&other, &parts.path().into(), &stop, &mut Silent).unwrap_err();
            assert!(matches!(error, OpenLoopError::Stopped { done: 0, .. }), "{error}");
        }
    }

    fn request_of<'a>(request: &Request<'a>) -> Request<'a> {
        Request { ..*request }
    }
}
