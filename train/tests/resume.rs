//! A run that stops and goes on ends in the same bits as one that never stopped.

use dpn_core::progress::{Progress, Silent};
use dpn_core::random::Stream;
use dpn_core::{ImuRecording, ImuSample, Sensor, Stamp};
use dpn_train::Device;
use dpn_train::config::{Schedule, TrainConfig};
use dpn_train::corpus::{Corpus, Member};
use dpn_train::run::{Run, RunError};
use dpn_train::split::Side;
use dpn_train::trainer::TrainError;
use rand::Rng;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};

pub(super) fn corpus() -> Corpus {
    let member = |name: &str, side, seed| {
        let mut rng = Stream::new(seed).named("resume test").rng();
        let samples = (0..4000)
            .map(|i| {
                let mut axes = || [(); 3].map(|()| (0.01 * f64::from(i)).sin() + 0.01 * rng.random::<f64>());
                ImuSample { t: Stamp::from_ns(5_000_000 * i64::from(i)), gyro: axes(), accel: axes() }
            })
            .collect();
        Member { name: name.into(), recording: ImuRecording::new(samples).unwrap(), side }
    };
    Corpus::new("made", vec![member("a", Side::Train, 1), member("b", Side::Test, 2)]).unwrap()
}

pub(super) fn config() -> TrainConfig {
    let mut config = TrainConfig::for_sensor(Sensor::Accel);
    config.network.channels = vec![4, 4, 8];
    config.network.kernels = vec![5, 3, 3];
    config.network.paddings = vec![2, 1, 1];
    config.network.hidden = vec![8, 4, 4];
    config.fit.epochs = 4;
    config.fit.batch = 20;
    config.fit.draws_per_window = 1;
    config.fit.validate_every = 1;
    config
}

fn weights(dir: &Path) -> Vec<u8> {
    std::fs::read(dir.join("accel.safetensors")).unwrap()
}

/// Sets a flag after so many updates.
pub(super) struct StopAfter<'a>(pub(super) u64, pub(super) &'a AtomicBool);

impl Progress for StopAfter<'_> {
    fn start(&mut self, _: &str, _: u64) {}
    fn step(&mut self, done: u64, _: &str) {
        if done >= self.0 {
            self.1.store(true, Ordering::Relaxed);
        }
    }
    fn finish(&mut self, _: &str) {}
}

#[test]
fn a_resumed_run_ends_in_the_same_bits() {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (corpus, device) = (corpus(), Device::Cpu);
    let never = AtomicBool::new(false);
    let run = Run::open(whole.path(), &config(), &corpus, &device, false).unwrap();
    run.train(&never, &mut Silent).unwrap();

    // Three updates an epoch: the eighth is inside the third epoch.
    let stop = AtomicBool::new(false);
    let run = Run::open(parts.path(), &config(), &corpus, &device, false).unwrap();
    let stopped = run.train(&stop, &mut StopAfter(8, &stop));
    assert!(matches!(stopped, Err(RunError::Train(TrainError::Stopped { epoch: 3 }))), "{stopped:?}");
    assert!(!parts.path().join("accel.safetensors").exists());
    let run = Run::open(parts.path(), &config(), &corpus, &device, true).unwrap();
    assert_eq!(run.epochs(), (2, 4));
    run.train(&never, &mut Silent).unwrap();
    assert_eq!(weights(whole.path()), weights(parts.path()));
}

#[test]
fn a_finished_run_that_is_made_longer_ends_in_the_bits_of_one_as_long_from_the_start() {
    let (whole, parts) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let (corpus, device) = (corpus(), Device::Cpu);
    let never = AtomicBool::new(false);
    let of = |epochs| {
        let mut config = config();
        config.fit.schedule = Schedule::Constant;
        (config.fit.warmup_steps, config.fit.validate_every, config.fit.epochs) = (5, 2, epochs);
        config
    };
    let train = |dir: &Path, config: &TrainConfig, resume: bool| {
        Run::open(dir, config, &corpus, &device, resume)?
            .train(&never, &mut Silent)
            .map(|(summary, _)| summary)
    };
    let summary = train(whole.path(), &of(5), false).unwrap();
    train(parts.path(), &of(2), false).unwrap();
    assert_ne!(weights(whole.path()), weights(parts.path()));
    assert_eq!(train(parts.path(), &of(5), true).unwrap(), summary);
    for file in
        ["accel.safetensors", "checkpoint.safetensors", "history.jsonl", "summary.json", "config.toml"]
    {
        let [a, b] = [&whole, &parts].map(|dir| std::fs::read(dir.path().join(file)).unwrap());
        assert!(a == b, "{file}");
    }

    // The fifth epoch was validated because it was the last one; a longer run would not have done so.
    let error = train(parts.path(), &of(6), true).unwrap_err();
    assert!(matches!(error, RunError::OtherLength { epochs: 6, .. }) && error.hint().is_some(), "{error}");
    assert!(matches!(train(parts.path(), &of(4), true), Err(RunError::OtherLength { .. })));
    // Nor could a cosine's learning rates be those of a longer one.
    let cosine = tempfile::tempdir().unwrap();
    train(cosine.path(), &config(), false).unwrap();
    let longer = TrainConfig { fit: dpn_train::config::FitConfig { epochs: 8, ..config().fit }, ..config() };
    let error = train(cosine.path(), &longer, true).unwrap_err().to_string();
    assert!(error.contains("cannot be made 8 epochs long") && error.contains("cosine"), "{error}");
}

#[test]
fn another_seed_gives_other_weights_and_is_not_resumed() {
    let dir = tempfile::tempdir().unwrap();
    let (corpus, device) = (corpus(), Device::Cpu);
    let never = AtomicBool::new(false);
    Run::open(dir.path(), &config(), &corpus, &device, false).unwrap().train(&never, &mut Silent).unwrap();
    let mut other = config();
    other.seed = 1;
    assert!(matches!(Run::open(dir.path(), &other, &corpus, &device, true), Err(RunError::Differs { .. })));
    assert!(matches!(
        Run::open(dir.path(), &config(), &corpus, &device, false),
        Err(RunError::Exists { epochs: 4, .. })
    ));
    // A checkpoint that cannot be read is not a run of no epochs.
    std::fs::write(dir.path().join("checkpoint.safetensors"), b"cut off").unwrap();
    assert!(matches!(Run::open(dir.path(), &config(), &corpus, &device, false), Err(RunError::Store(_))));
    let second = tempfile::tempdir().unwrap();
    Run::open(second.path(), &other, &corpus, &device, false).unwrap().train(&never, &mut Silent).unwrap();
    assert_ne!(weights(dir.path()), weights(second.path()));
}
