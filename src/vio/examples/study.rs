//! Runs the window on EuRoC's tracks from ground-truth states and prints position errors: for work on the window itself.
//!
//! `study DATA SEQ[,SEQ..]|all FACTOR[,FACTOR..] [key=value ...]`

use dpn_core::camera::PinholeRadtan;
use dpn_core::io::asl::Sequence;
use dpn_core::io::read_tracks;
use dpn_core::{ImuNoise, Stamp, TrackFrame};
use dpn_vio::estimator::{Estimator, EstimatorConfig, StartFrame};
use dpn_vio::preint::{NoisySample, Preintegration};
use dpn_vio::{ImuBias, NavState};
use nalgebra::{Isometry3, Matrix3, Vector3};
use std::path::{Path, PathBuf};

const ALL: [(&str, f64); 11] = [
    ("MH_01_easy", 40.0),
    ("MH_02_easy", 35.0),
    ("MH_03_medium", 0.0),
    ("MH_04_difficult", 0.0),
    ("MH_05_difficult", 0.0),
    ("V1_01_easy", 0.0),
    ("V1_02_medium", 0.0),
    ("V1_03_difficult", 0.0),
    ("V2_01_easy", 0.0),
    ("V2_02_medium", 0.0),
    ("V2_03_difficult", 0.0),
];

struct Truth(Vec<(Stamp, Isometry3<f64>)>);

impl Truth {
    fn at(&self, t: Stamp) -> Option<Isometry3<f64>> {
        let k = self.0.partition_point(|(s, _)| *s <= t);
        if k == 0 || k >= self.0.len() {
            return None;
        }
        let ((a, pa), (b, pb)) = (&self.0[k - 1], &self.0[k]);
        let share = t.seconds_since(*a) / b.seconds_since(*a);
        Some(Isometry3::from_parts(
            pa.translation.vector.lerp(&pb.translation.vector, share).into(),
            pa.rotation.slerp(&pb.rotation, share),
        ))
    }
}

fn ate(pairs: &[(Vector3<f64>, Vector3<f64>)]) -> f64 {
    let n = pairs.len() as f64;
    let (mut ma, mut mb) = (Vector3::zeros(), Vector3::zeros());
    for (a, b) in pairs {
        ma += a / n;
        mb += b / n;
    }
    let mut cov = Matrix3::zeros();
    for (a, b) in pairs {
        cov += (b - mb) * (a - ma).transpose();
    }
    let svd = cov.svd(true, true);
    let (u, vt) = (svd.u.unwrap(), svd.v_t.unwrap());
    let mut d = Matrix3::identity();
    d[(2, 2)] = (u * vt).determinant().signum();
    let r = u * d * vt;
    (pairs.iter().map(|(a, b)| ((b - mb) - r * (a - ma)).norm_squared()).sum::<f64>() / n).sqrt()
}

struct Outcome {
    ate: f64,
    cpu: f64,
    seconds: f64,
    iterations: f64,
    restarts: usize,
    whitened: f64,
    stages: [f64; 5],
}

fn run(data: &Path, name: &str, from: f64, factor: f64, config: &EstimatorConfig) -> Outcome {
    let sequence = Sequence::open(&data.join("euroc").join(name)).unwrap();
    let imu = sequence.imu().unwrap();
    let truth = sequence.ground_truth().unwrap();
    let truth = Truth(truth.states().iter().map(|s| (s.t, s.world_from_body)).collect());
    let camera_config = sequence.camera_config().unwrap().unwrap();
    let camera = PinholeRadtan::try_from(&camera_config).unwrap();
    let tracks = std::env::var("TRACKS").map_or_else(|_| data.join("tracks"), PathBuf::from);
    let frames = read_tracks(&tracks.join(format!("{name}.txt"))).unwrap();
    let from = if std::env::var_os("FIRST").is_some() { 0.0 } else { from };
    let start = frames[0].t.plus_seconds(from);
    let frames: Vec<TrackFrame> = frames.into_iter().filter(|f| f.t >= start).collect();
    let noise = ImuNoise::from_values([0.08 * factor; 3], [0.004 * factor; 3]).unwrap();
    let samples: Vec<NoisySample> = imu.samples().iter().map(|s| NoisySample { sample: *s, noise }).collect();
    let mut estimator = Estimator::new(config.clone(), camera, camera_config.body_from_cam, 1).unwrap();
    let mut begin: Vec<StartFrame> = Vec::new();
    let count = if std::env::var_os("GT").is_some() { 11 } else { 0 };
    for frame in &frames[..count] {
        let pose = truth.at(frame.t).unwrap();
        let ahead = truth.at(frame.t.plus_seconds(0.05)).unwrap_or(pose);
        let vel = (ahead.translation.vector - pose.translation.vector) / 0.05;
        let preint = begin.last().map(|last: &StartFrame| {
            let mut between = samples.iter().filter(|s| s.sample.t >= last.t && s.sample.t <= frame.t);
            let mut p = Preintegration::new(config.imu, ImuBias::zero(), *between.next().unwrap());
            between.for_each(|s| p.push(*s));
            p
        });
        let state = NavState { world_from_body: pose, vel_in_world: vel, bias: ImuBias::zero() };
        begin.push(StartFrame { t: frame.t, state, preint, seen: estimator.sightings(frame) });
    }
    let last = begin.last().map_or(frames[0].t, |b| b.t);
    if count > 0 {
        estimator.start(begin);
    }
    for s in &samples {
        if s.sample.t.plus_seconds(0.006) >= last {
            estimator.feed_imu(*s).unwrap();
        }
    }
    let mut pairs = Vec::new();
    let mut cpu = 0.0;
    for frame in &frames[count..] {
        estimator.feed_frame(frame.clone()).unwrap();
        while let Some(update) = estimator.next_update() {
            cpu += update.seconds;
            if std::env::var_os("TRACE").is_some() {
                let e = update.state.and_then(|s| {
                    truth
                        .at(update.t)
                        .map(|p| (s.world_from_body.translation.vector - p.translation.vector).norm())
                });
                println!(
                    "{:.1} {:?} tracked {} landmarks {} outliers {} it {} err {e:?} v {:.2?} ba {:.3?} bg {:.4?}",
                    update.t.seconds_since(frames[0].t),
                    update.phase,
                    update.tracked,
                    update.landmarks,
                    update.outliers,
                    update.iterations,
                    update.state.map(|s| s.vel_in_world.norm()),
                    update.state.map(|s| s.bias.accel.norm()),
                    update.state.map(|s| s.bias.gyro.norm())
                );
            }
            if let (Some(state), Some(truth)) = (update.state, truth.at(update.t)) {
                pairs.push((state.world_from_body.translation.vector, truth.translation.vector));
            }
        }
    }
    let report = estimator.report();
    let seconds = frames[frames.len() - 1].t.seconds_since(frames[0].t);
    if let Some(t) = report.initialised {
        if std::env::var_os("INIT").is_some() {
            eprintln!("{name} x{factor}: init {:.1}", t.seconds_since(frames[0].t));
        }
    }
    if std::env::var_os("INIT").is_some() {
        eprintln!(
            "{name} x{factor}: offset {:.2} ms camera {:.3?}",
            1e3 * estimator.window().time_offset(),
            estimator.window().body_from_cam().translation.vector.as_slice()
        );
    }
    for (t, reason) in &report.restarts {
        eprintln!("{name} x{factor}: at {:.1} s: {reason}", t.seconds_since(frames[0].t));
    }
    Outcome {
        ate: if pairs.len() > 10 { ate(&pairs) } else { f64::NAN },
        cpu,
        seconds,
        iterations: report.iterations as f64 / report.frames as f64,
        restarts: report.restarts.len(),
        whitened: report.whitened_mean().unwrap_or(f64::NAN),
        stages: report.seconds,
    }
}

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let data = PathBuf::from(&args[0]);
    let names: Vec<(&str, f64)> = ALL
        .into_iter()
        .filter(|(n, _)| args[1] == "all" || args[1].split(',').any(|a| n.starts_with(a)))
        .collect();
    let factors: Vec<f64> = args[2].split(',').map(|f| f.parse().unwrap()).collect();
    let text: String = args[3..].iter().map(|a| format!("{}\n", a.replacen('=', " = ", 1))).collect();
    let config: EstimatorConfig = toml::from_str(&text).unwrap();
    let jobs: Vec<(usize, usize)> =
        (0..names.len()).flat_map(|n| (0..factors.len()).map(move |f| (n, f))).collect();
    let next = std::sync::atomic::AtomicUsize::new(0);
    let results = std::sync::Mutex::new(vec![None; jobs.len()]);
    std::thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, std::sync::atomic::Ordering::Relaxed);
                    let Some((n, f)) = jobs.get(k) else { break };
                    let o = run(&data, names[*n].0, names[*n].1, factors[*f], &config);
                    results.lock().unwrap()[k] = Some((
                        o.ate,
                        o.cpu / o.seconds,
                        o.iterations,
                        o.restarts,
                        o.whitened,
                        o.stages.map(|s| s / o.seconds),
                    ));
                }
            });
        }
    });
    let results = results.into_inner().unwrap();
    let mut means = vec![0.0; factors.len()];
    for (n, (name, _)) in names.iter().enumerate() {
        print!("{name:16}");
        for f in 0..factors.len() {
            let (ate, cpu, iterations, restarts, whitened, _) = results[n * factors.len() + f].unwrap();
            means[f] += ate / names.len() as f64;
            print!("  {ate:.3} r{restarts} i{iterations:.1} w{whitened:5.2} {:.1}ms", 1e3 * cpu);
        }
        println!();
    }
    print!("{:16}", "mean");
    means.iter().for_each(|m| print!("  {m:.3}                   "));
    println!();
    let mut stages = [0.0; 5];
    for r in results.iter().flatten() {
        for k in 0..5 {
            stages[k] += 1e3 * r.5[k] / results.len() as f64;
        }
    }
    println!(
        "ms per s of data: feed {:.2} init {:.2} solve {:.2} reject {:.2} slide {:.2}",
        stages[0], stages[1], stages[2], stages[3], stages[4]
    );
}
