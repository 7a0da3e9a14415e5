//! From a spec to a noise for every sample of a recording.

use super::controls::{MeanSquare, shuffled};
use super::error::{LEAST, MOST};
use super::{Causal, CausalError, Feed, NoiseError};
use dpn_core::estimate::{NoiseSpec, Schedule, Watch};
use dpn_core::random::Stream;
use dpn_core::time::median_step_s;
use dpn_core::{ImuNoise, ImuRecording, NoiseTrack, SampleRate, Sensor};
use dpn_io::read_noise_track;
use dpn_pronet::network::Network;
use std::path::Path;
use std::sync::Arc;

/// What a spec may need besides the recording it is for. The sweep keeps the answers; [`Fresh`] makes them anew.
pub trait Sources {
    /// The track of a spec that is no control, on the recording at hand.
    ///
    /// # Errors
    /// As [`of_recording`].
    fn track(&self, source: &NoiseSpec) -> Result<Arc<NoiseTrack>, NoiseError>;

    /// Root mean square of a spec that is no control over the training sequences.
    ///
    /// # Errors
    /// No training sequences; as [`of_recording`].
    fn training_mean(&self, source: &NoiseSpec) -> Result<ImuNoise, NoiseError>;

    /// The noise in force in a run that learned its levels, for the controls made of it.
    ///
    /// # Errors
    /// There was no such run.
    fn learned(&self, spec: &NoiseSpec) -> Result<Arc<NoiseTrack>, NoiseError> {
        Err(NoiseError::NotLearned { spec: spec.to_string() })
    }
}

/// Sources to which the noise in force in a first run of the same cell is known.
pub struct AfterRun<'a> {
    /// All else.
    pub sources: &'a dyn Sources,
    /// The noise in force.
    pub in_force: Arc<NoiseTrack>,
}

impl Sources for AfterRun<'_> {
    fn track(&self, source: &NoiseSpec) -> Result<Arc<NoiseTrack>, NoiseError> {
        self.sources.track(source)
    }

    fn training_mean(&self, source: &NoiseSpec) -> Result<ImuNoise, NoiseError> {
        self.sources.training_mean(source)
    }

    fn learned(&self, _: &NoiseSpec) -> Result<Arc<NoiseTrack>, NoiseError> {
        Ok(Arc::clone(&self.in_force))
    }
}

/// A recording and what is known of its noise.
#[derive(Debug, Clone, Copy)]
pub struct Recorded<'a> {
    /// Its name, for messages.
    pub name: &'a str,
    /// The samples.
    pub imu: &'a ImuRecording,
    /// The true deviations, where it is simulated.
    pub oracle: Option<&'a NoiseTrack>,
}

/// Sources of one recording, made when asked for, without training sequences.
#[derive(Debug, Clone, Copy)]
pub struct Fresh<'a> {
    /// The recording.
    pub recorded: Recorded<'a>,
    /// Networks to choose from.
    pub networks: &'a [Network],
}

impl Sources for Fresh<'_> {
    fn track(&self, source: &NoiseSpec) -> Result<Arc<NoiseTrack>, NoiseError> {
        of_recording(source, &self.recorded, self.networks).map(Arc::new)
    }

    fn training_mean(&self, source: &NoiseSpec) -> Result<ImuNoise, NoiseError> {
        Err(NoiseError::NoTraining { spec: format!("mean-of-train({source})") })
    }
}

/// That a noise told can be computed with.
///
/// # Errors
/// A deviation that no IMU has.
pub fn check_range(noise: &ImuNoise, spec: &NoiseSpec) -> Result<(), NoiseError> {
    for sensor in Sensor::ALL {
        for value in noise.of(sensor) {
            if !(LEAST..=MOST).contains(&value) {
                return Err(NoiseError::Absurd { spec: spec.to_string(), sensor, value });
            }
        }
    }
    Ok(())
}

/// The noise in force at every sample of `imu`; a control that permutes draws from `stream`.
///
/// # Errors
/// What `sources` cannot give; a deviation that no IMU has.
pub fn track(
    spec: &NoiseSpec,
    imu: &ImuRecording,
    sources: &dyn Sources,
    stream: &Stream,
) -> Result<Arc<NoiseTrack>, NoiseError> {
    let track = made(spec, imu, sources, stream)?;
    track.noises().iter().try_for_each(|noise| check_range(noise, spec))?;
    Ok(track)
}

/// The same, whatever it says.
fn made(
    spec: &NoiseSpec,
    imu: &ImuRecording,
    sources: &dyn Sources,
    stream: &Stream,
) -> Result<Arc<NoiseTrack>, NoiseError> {
    let made_of = |of: &NoiseSpec, stream: &Stream| {
        if of.is_learned() { sources.learned(of) } else { made(of, imu, sources, stream) }
    };
    match spec {
        NoiseSpec::Shuffled(of) => {
            let stream = stream.named("shuffled");
            Ok(Arc::new(shuffled(&*made_of(of, &stream)?, &stream)))
        }
        NoiseSpec::Learned(of) => made(of, imu, sources, stream),
        NoiseSpec::Mean(of) => {
            let track = made_of(of, stream)?;
            let mut mean = MeanSquare::default();
            mean.add(&track);
            let mean = mean.root().ok_or_else(|| NoiseError::TooLarge { spec: spec.to_string() })?;
            Ok(Arc::new(constant(imu, mean)))
        }
        NoiseSpec::MeanOfTrain(of) => Ok(Arc::new(constant(imu, sources.training_mean(of.source())?))),
        NoiseSpec::Plus { of, constant } => {
            let track = made(of, imu, sources, stream)?;
            let mut constant = constant.model(Schedule::default()).map_err(CausalError::from)?;
            let constant = NoiseTrack::of(constant.as_mut(), imu);
            let both = root_sum_square(&track, &constant);
            both.map(Arc::new).ok_or_else(|| NoiseError::TooLarge { spec: spec.to_string() })
        }
        source => sources.track(source),
    }
}

/// Variances added, sample by sample, of two tracks on the same stamps; `None` where a sum is beyond all numbers.
fn root_sum_square(a: &NoiseTrack, b: &NoiseTrack) -> Option<NoiseTrack> {
    let sum = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|axis| a[axis].hypot(b[axis]));
    let both = |(a, b): (&ImuNoise, &ImuNoise)| {
        let of = |sensor| sum(a.of(sensor), b.of(sensor));
        ImuNoise::from_values(of(Sensor::Accel), of(Sensor::Gyro)).ok()
    };
    let noises: Option<Vec<ImuNoise>> = a.noises().iter().zip(b.noises()).map(both).collect();
    Some(a.with_noises(noises?))
}

/// The same noise at every sample.
fn constant(imu: &ImuRecording, noise: ImuNoise) -> NoiseTrack {
    NoiseTrack::of(&mut dpn_core::noise::Constant::new("constant", noise), imu)
}

/// What says the noise of a spec sample by sample, for samples that come at `rate`, as the odometry is given it: over 200 samples, every 10; of networks every twentieth of a second. Of `self` the noise
/// whose levels are estimated. `name` is the recording's, for messages.
///
/// # Errors
/// A spec that must know the whole recording; networks that are not there or are of another rate; parameters out of range.
pub fn live(
    spec: &NoiseSpec,
    name: &str,
    rate: SampleRate,
    networks: &[Network],
) -> Result<Feed, NoiseError> {
    if let NoiseSpec::Learned(of) = spec {
        return live(of, name, rate, networks);
    }
    let Schedule { window, hop, rate: usual } = Schedule::default();
    let feed = Causal::new(spec, rate, networks).and_then(|causal| {
        let slower = causal.trained_hz().map_or(1.0, |hz| hz / usual.hz());
        causal.feed(window, (hop as f64 * slower).round().max(1.0) as usize)
    });
    feed.map_err(|source| NoiseError::Causal { recording: name.to_owned(), source })
}

/// Seconds at the begin in which no estimator has a full window.
const UNKNOWN_S: f64 = 1.5;

/// What the spectrum of a recording has against the noise that `spec`, an estimate of a second at a time, said along it: words for people, of what nothing else tells the
/// odometry. Nothing of constants, files and what is learned.
pub fn doubts(spec: &NoiseSpec, imu: &ImuRecording, said: &NoiseTrack) -> Vec<String> {
    let Some(mut watch) = Watch::whole(imu.rate()).filter(|_| spec.is_estimate()) else { return Vec::new() };
    let start = imu.samples()[0].t;
    for (sample, noise) in imu.samples().iter().zip(said.noises()) {
        watch.feed(sample, (sample.t.seconds_since(start) > UNKNOWN_S).then_some(noise));
    }
    watch.at_end().iter().flatten().map(|doubt| doubt.words(&spec.to_string())).collect()
}

/// The track of a spec that is no control; causal, but for `file` and `oracle`, which are as given.
///
/// # Errors
/// Networks that are not there or are of another rate; a file that cannot be read, does not cover the samples or holds a zero; `oracle`
/// on a recording; parameters out of range.
pub fn of_recording(
    source: &NoiseSpec,
    recorded: &Recorded<'_>,
    networks: &[Network],
) -> Result<NoiseTrack, NoiseError> {
    let imu = recorded.imu;
    match source {
        NoiseSpec::Sensors(_) | NoiseSpec::DualProNet { .. } => {
            Ok(NoiseTrack::of(&mut live(source, recorded.name, imu.rate(), networks)?, imu))
        }
        NoiseSpec::File(path) => held(path, source, recorded),
        NoiseSpec::Oracle => recorded
            .oracle
            .cloned()
            .ok_or_else(|| NoiseError::NoOracle { recording: recorded.name.to_owned() }),
        made_of_another => of_recording(made_of_another.source(), recorded, networks),
    }
}

/// A track on disk, each value held until the next.
fn held(path: &Path, spec: &NoiseSpec, recorded: &Recorded<'_>) -> Result<NoiseTrack, NoiseError> {
    let file = read_noise_track(path)?;
    let (stamps, samples) = (file.stamps(), recorded.imu.samples());
    let (first, last) = (samples[0].t, samples[samples.len() - 1].t);
    let (from, to) = (stamps[0], stamps[stamps.len() - 1]);
    // A single value has no step.
    let step = median_step_s(stamps.iter().copied()).unwrap_or(0.0);
    if from > first || to.plus_seconds(1.5 * step) < last {
        return Err(NoiseError::NotCovered {
            path: path.to_path_buf(),
            from_ns: from.ns(),
            to_ns: to.ns(),
            recording: recorded.name.to_owned(),
            imu_from_ns: first.ns(),
            imu_to_ns: last.ns(),
        });
    }
    // Longer than this without a value is a hole, not a slower track.
    let longest = (10.0 * step).max(0.5);
    let mut noises = Vec::with_capacity(samples.len());
    for sample in samples {
        let at = stamps.partition_point(|t| *t <= sample.t) - 1;
        if let Some(next) = stamps.get(at + 1).filter(|next| next.seconds_since(stamps[at]) > longest) {
            return Err(NoiseError::Hole {
                path: path.to_path_buf(),
                from_ns: stamps[at].ns(),
                to_ns: next.ns(),
                recording: recorded.name.to_owned(),
            });
        }
        let noise = file.noises()[at];
        if Sensor::ALL.into_iter().any(|sensor| noise.of(sensor).contains(&0.0)) {
            return Err(NoiseError::Zero {
                spec: spec.to_string(),
                recording: recorded.name.to_owned(),
                t_ns: sample.t.ns(),
            });
        }
        noises.push(noise);
    }
    let stamps = samples.iter().map(|s| s.t).collect();
    Ok(NoiseTrack::new(stamps, noises).expect("a recording's stamps increase"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use dpn_core::{ImuSample, NoiseModel, Stamp};
    use dpn_io::write_noise_track;
    use rand::Rng;

    fn recording(samples: i64) -> ImuRecording {
        let sample = |i: i64| ImuSample {
            t: Stamp::from_ns(1_000_000_000 + 5_000_000 * i),
            gyro: [0.01 * (i % 7) as f64, 0.0, 0.02 * (i % 3) as f64],
            accel: [0.1 * (i % 5) as f64, 0.2 * (i % 11) as f64, 9.81],
        };
        ImuRecording::new((0..samples).map(sample).collect()).unwrap()
    }

    fn track(spec: &str, imu: &ImuRecording, seed: u64) -> Result<Arc<NoiseTrack>, NoiseError> {
        let recorded = Recorded { name: "made-up", imu, oracle: None };
        let sources = Fresh { recorded, networks: &[] };
        super::track(&spec.parse().unwrap(), imu, &sources, &Stream::new(seed))
    }

    #[test]
    fn the_mean_of_a_constant_is_the_constant_and_the_mean_of_a_shuffle_that_of_its_source() {
        let imu = recording(1000);
        let (found, told) = (track("mean(x4,x1)", &imu, 0).unwrap(), track("x4,x1", &imu, 0).unwrap());
        for (found, told) in found.noises().iter().zip(told.noises()) {
            for sensor in Sensor::ALL {
                assert!((0..3).all(|axis| (found.of(sensor)[axis] - told.of(sensor)[axis]).abs() < 1e-12));
            }
        }
        let (a, b) =
            (track("mean(diff2)", &imu, 0).unwrap(), track("mean(shuffled(diff2))", &imu, 5).unwrap());
        for sensor in Sensor::ALL {
            for (a, b) in a.noises()[17].of(sensor).into_iter().zip(b.noises()[900].of(sensor)) {
                assert!((a / b - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn plus_adds_variances_sample_by_sample() {
        let imu = recording(1000);
        let (plain, more) = (track("diff2", &imu, 0).unwrap(), track("plus(diff2,x4)", &imu, 0).unwrap());
        for (plain, more) in plain.noises().iter().zip(more.noises()) {
            for (sensor, constant) in [(Sensor::Accel, 0.32), (Sensor::Gyro, 0.016)] {
                for axis in 0..3 {
                    let expected = plain.of(sensor)[axis].hypot(constant);
                    assert!((more.of(sensor)[axis] - expected).abs() < 1e-12);
                }
            }
        }
    }

    #[test]
    fn deviations_beyond_all_numbers_are_refused_and_not_answered_with_the_source() {
        let imu = recording(10);
        for spec in ["mean(const(1e200,1))", "plus(const(1.7e308,1),const(1.7e308,1))"] {
            let error = track(spec, &imu, 0).unwrap_err();
            assert!(matches!(error, NoiseError::TooLarge { .. }), "{spec}: {error}");
        }
    }

    #[test]
    fn a_shuffle_is_a_function_of_its_seed_and_differs_from_its_source() {
        let imu = recording(4000);
        let of = |seed| track("shuffled(diff2)", &imu, seed).unwrap();
        assert_eq!(of(1), of(1));
        assert_ne!(of(1), of(2));
        assert_ne!(of(1), track("diff2", &imu, 1).unwrap());
    }

    #[test]
    fn a_log_of_twice_the_networks_rate_has_the_noise_of_means_of_two_and_a_slower_one_is_refused() {
        let models = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../models");
        let load = |sensor: &str| Network::load(&models.join(sensor).join("sg11-s0.safetensors")).unwrap();
        let networks = [load("accel"), load("gyro")];
        let whole = recording(2000);
        let at = |step_ns: i64| {
            let samples = whole.samples().iter().enumerate();
            let stamped = samples.map(|(i, s)| ImuSample { t: Stamp::from_ns(step_ns * i as i64), ..*s });
            ImuRecording::new(stamped.collect()).unwrap()
        };
        let means = whole.samples().chunks_exact(2).enumerate().map(|(i, pair)| {
            let mean = |of: fn(&ImuSample) -> [f64; 3]| {
                [0, 1, 2].map(|axis| (of(&pair[0])[axis] + of(&pair[1])[axis]) / 2.0)
            };
            ImuSample {
                t: Stamp::from_ns(5_000_000 * i as i64),
                accel: mean(|s| s.accel),
                gyro: mean(|s| s.gyro),
            }
        });
        let means = ImuRecording::new(means.collect()).unwrap();
        let of = |imu: &ImuRecording| {
            let recorded = Recorded { name: "made-up", imu, oracle: None };
            of_recording(&"dualpronet".parse().unwrap(), &recorded, &networks)
        };
        let (fast, slow) = (of(&at(2_500_000)).unwrap(), of(&means).unwrap());
        assert_ne!(slow.noises()[0], slow.noises()[999]);
        for (i, noise) in fast.noises().iter().enumerate().skip(1) {
            for sensor in Sensor::ALL {
                let mean = slow.noises()[(i - 1) / 2].of(sensor);
                let one = noise.of(sensor);
                let off = (0..3).map(|axis| (one[axis] / (2f64.sqrt() * mean[axis]) - 1.0).abs());
                assert!(off.fold(0.0, f64::max) < 1e-9, "{i}");
            }
        }
        // A rate in between is averaged too.
        assert!(of(&at(3_333_333)).is_ok());
        let error = of(&at(10_000_000)).unwrap_err();
        assert!(error.to_string().starts_with("made-up: the log has 100.0 Hz; "), "{error}");
        assert!(error.hint().unwrap().starts_with("faster logs are averaged to 200 Hz by themselves"));
    }

    #[test]
    fn raw_flight_is_in_the_range_of_its_networks_and_a_low_pass_out_of_the_papers() {
        let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
        let networks = dpn_pronet::network::load_all(&root.join("models")).unwrap();
        let outside = |spec: &str, imu: &ImuRecording| {
            let mut feed = live(&spec.parse().unwrap(), "r", imu.rate(), &networks).unwrap();
            for sample in imu.samples() {
                feed.feed(sample);
            }
            let judged = feed.judged();
            Sensor::ALL.map(|sensor| judged.of(sensor).outside as f64 / judged.of(sensor).windows as f64)
        };
        let flown =
            dpn_io::asl::Sequence::open(&root.join("tests/data/euroc/V1_01_easy")).unwrap().imu().unwrap();
        assert!(outside("dualpronet(flight-s0)", &flown).iter().all(|share| *share < 0.05));
        assert!(outside("dualpronet", &flown)[0] > 0.5);
        // White noise in the middle of the paper's range, and the same behind a low pass.
        let mut rng = Stream::new(2).named("range").rng();
        let mut white = || [0; 3].map(|_| 12f64.sqrt() * (rng.random::<f64>() - 0.5));
        let samples: Vec<ImuSample> = (0..2600)
            .map(|i| ImuSample {
                t: Stamp::from_ns(5_000_000 * i),
                accel: white().map(|v| 0.1 * v),
                gyro: white().map(|v| 0.007 * v),
            })
            .collect();
        // Butterworth's two poles at 42 Hz.
        let k = (std::f64::consts::PI * 42.0 / 200.0).tan();
        let (root, norm) = (2f64.sqrt(), 1.0 / (1.0 + 2f64.sqrt() * k + k * k));
        let mut slow = samples.clone();
        for i in 2..slow.len() {
            for sensor in Sensor::ALL {
                let out: [f64; 3] = std::array::from_fn(|axis| {
                    let x = |back: usize| samples[i - back].of(sensor)[axis];
                    let y = |back: usize| slow[i - back].of(sensor)[axis];
                    let fed = k * k * (x(0) + 2.0 * x(1) + x(2));
                    norm * (fed - 2.0 * (k * k - 1.0) * y(1) - (1.0 - root * k + k * k) * y(2))
                });
                match sensor {
                    Sensor::Accel => slow[i].accel = out,
                    Sensor::Gyro => slow[i].gyro = out,
                }
            }
        }
        let slow = ImuRecording::new(slow).unwrap();
        let white = ImuRecording::new(samples).unwrap();
        assert!(outside("dualpronet", &white).iter().all(|share| *share < 0.05));
        assert!(outside("dualpronet", &slow).iter().all(|share| *share > 0.9));
        // What the odometry is told is held against the spectrum, and what was given is not.
        let against = |spec: &str, imu: &ImuRecording| {
            let spec: NoiseSpec = spec.parse().unwrap();
            let said = NoiseTrack::of(&mut live(&spec, "r", imu.rate(), &networks).unwrap(), imu);
            doubts(&spec, imu, &said)
        };
        assert_eq!(against("diff2", &white), [""; 0]);
        assert_eq!(against("x4", &slow), [""; 0]);
        let words = against("diff2", &slow);
        assert!(words.len() == 2 && words[1].starts_with("NOT KNOWN: the gyro's spectrum"), "{words:?}");
    }

    #[test]
    fn what_cannot_be_known_here_is_refused() {
        let imu = recording(400);
        for (spec, words) in [
            ("oracle", "nobody knows"),
            ("mean(oracle)", "nobody knows"),
            ("mean-of-train(x2)", "training sequences"),
            ("dualpronet(sg9-s0)", "no accel network `sg9-s0`"),
        ] {
            let text = track(spec, &imu, 0).unwrap_err().to_string();
            assert!(text.contains(words), "{spec}: {text}");
        }
    }

    #[test]
    fn a_file_must_cover_the_samples_without_holes_and_zeros() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("noise.csv");
        let imu = recording(1000);
        let spec = format!("file(\"{}\")", path.display());
        let whole = track("diff2", &imu, 0).unwrap();
        let write = |keep: &dyn Fn(usize) -> bool, zero: Option<usize>| {
            let kept: Vec<usize> = (0..1000).filter(|i| keep(*i)).collect();
            let noise = |i: &usize| {
                if zero == Some(*i) {
                    ImuNoise::from_values([0.1, 0.0, 0.1], [0.1; 3]).unwrap()
                } else {
                    whole.noises()[*i]
                }
            };
            let noises = kept.iter().map(noise).collect();
            let track = NoiseTrack::new(kept.iter().map(|i| whole.stamps()[*i]).collect(), noises).unwrap();
            write_noise_track(&path, &track).unwrap();
        };
        write(&|_| true, None);
        assert_eq!(track(&spec, &imu, 0).unwrap(), whole);
        // At a twentieth of the rate each value is held.
        write(&|i| i % 20 == 0, None);
        let slow = track(&spec, &imu, 0).unwrap();
        assert_eq!(slow.noises()[259], whole.noises()[240]);
        for (keep, zero, words) in [
            (&(|i: usize| i > 0) as &dyn Fn(usize) -> bool, None, "but made-up's samples from 1000000000"),
            (&|i| i < 900, None, "but made-up's samples"),
            (&|i| !(300..500).contains(&i), None, "no noise from 2495000000 to 3500000000 ns"),
            (&|_| true, Some(7), "a deviation of 0 for made-up at 1035000000 ns"),
        ] {
            write(keep, zero);
            let text = track(&spec, &imu, 0).unwrap_err().to_string();
            assert!(text.contains(words), "{words}: {text}");
        }
    }
}
