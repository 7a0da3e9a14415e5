//! The card against the processor's kernels, which `dpn_pronet` holds to the plain composition. Needs a Vulkan driver, Mesa's lavapipe at least.

use crate::kernels::draw::threefry;
use crate::room::Room;
use crate::{Examples, Gpu, GpuError, LevelDraw, Loss, Source, State, Step, Training, Turns};
use cubecl::prelude::*;
use dpn_core::config::Validate;
use dpn_core::random::Stream;
use dpn_pronet::config::{BlockOrder, Head, Input, NormAxes, Pool};
use dpn_pronet::init::initial_parameters;
use dpn_pronet::{AdamConfig, Device, ProNetConfig, Trainable};
use rand::Rng;
use rand::seq::IndexedRandom;

fn pick<T: Copy>(choices: &[T], rng: &mut impl Rng) -> T {
    *choices.choose(rng).unwrap()
}

/// A small network with every choice drawn, in turn where there are few.
fn random_config(case: usize, rng: &mut impl Rng) -> ProNetConfig {
    let blocks = 1 + case % 3;
    let mut config = ProNetConfig {
        window: rng.random_range(30..60),
        input: Input::ALL[case % 3],
        block_order: BlockOrder::ALL[case % 2],
        norm_axes: if case % 5 == 4 { NormAxes::None } else { NormAxes::Channels },
        channels: (0..blocks).map(|_| pick(&[1, 3, 16, 19, 32], rng)).collect(),
        kernels: (0..blocks).map(|_| rng.random_range(1..8)).collect(),
        strides: (0..blocks).map(|_| rng.random_range(1..4)).collect(),
        paddings: vec![0; blocks],
        conv_bias: rng.random(),
        leak: pick(&[0.01, 0.1, 1.0], rng),
        pool: Pool::ALL[(case / 2) % 3],
        hidden: (0..case % 4).map(|_| pick(&[1, 5, 16, 33], rng)).collect(),
        head: Head::ALL[case % 4],
        ..ProNetConfig::default()
    };
    for (p, k) in config.paddings.iter_mut().zip(&config.kernels) {
        *p = rng.random_range(0..*k);
    }
    config
}

fn windows(count: usize, length: usize, rng: &mut impl Rng) -> Vec<f32> {
    (0..count * length).map(|_| 0.2 * (rng.random::<f32>() - 0.5)).collect()
}

/// Largest difference in units of the largest number.
fn apart(a: &[f32], b: &[f32]) -> f32 {
    assert_eq!(a.len(), b.len());
    assert!(a.iter().chain(b).all(|v| v.is_finite()), "not finite");
    let largest = a.iter().chain(b).fold(1e-30f32, |m, v| m.max(v.abs()));
    a.iter().zip(b).fold(0f32, |m, (x, y)| m.max((x - y).abs())) / largest
}

/// Mean loss and its derivatives, as `dpn_train` has them.
fn loss(kind: Loss, unit: f32, answers: &[f32], labels: &[f32]) -> (f64, Vec<f32>) {
    let outputs = answers.len() / labels.len();
    let share = 1.0 / labels.len() as f32;
    let (mut value, mut d) = (0.0, vec![0.0; answers.len()]);
    for (i, label) in labels.iter().enumerate() {
        let at = i * outputs;
        let (s, log) = (answers[at], (answers[at] / label).ln());
        let (v, slope) = match kind {
            Loss::Mse => (((s - label) / unit).powi(2), 2.0 * (s - label) / unit / unit),
            Loss::LogMse => (log * log, 2.0 * log / s),
            Loss::LogNll => {
                let spread = answers[at + 1];
                d[at + 1] = share * (1.0 / spread - log * log / spread.powi(3));
                (0.5 * (log / spread).powi(2) + spread.ln(), log / (spread * spread) / s)
            }
        };
        value += f64::from(share * v);
        d[at] = share * slope;
    }
    (value, d)
}

#[test]
fn answers_and_gradients_are_the_processors_for_any_configuration() {
    let gpu = Gpu::open().unwrap();
    println!("on {}", gpu.adapter());
    let mut cases = 0;
    for case in 0.. {
        if cases == 12 {
            break;
        }
        let stream = Stream::new(12).named("card").index(case);
        let mut rng = stream.rng();
        let config = random_config(case as usize, &mut rng);
        if config.validate().is_err() {
            continue;
        }
        cases += 1;
        let flat: Vec<f32> = initial_parameters(&config, &stream.named("init"))
            .iter()
            .map(|p| p + 0.2 * (rng.random::<f32>() - 0.5))
            .collect();
        // More windows than the smallest batch, so that workgroups take several.
        let count = rng.random_range(1..40);
        let x = windows(count, config.window, &mut rng);
        let labels: Vec<f32> = (0..count).map(|_| 0.02 + 0.1 * rng.random::<f32>()).collect();
        let kind = match config.head {
            Head::LogSigmaAndSpread => Loss::LogNll,
            Head::LogSigma => Loss::LogMse,
            _ => Loss::Mse,
        };
        let mut said = Vec::new();
        let (value, gradient) =
            Trainable::new(&config, &Device::Cpu).unwrap().gradient(&flat, &x, |answers| {
                said = answers.to_vec();
                loss(kind, config.output_scale() as f32, answers, &labels)
            });
        let adam = AdamConfig { beta1: 0.0, ..AdamConfig::default() };
        let training = Training::new(&gpu, &config, kind, adam, 0.0);
        let answers = training.answers(&flat, x.clone()).unwrap();
        let mut state = State::new(flat);
        let step = [Step { number: 1, rate: 0.0, keep: 0.0 }];
        let losses = training.steps(&mut state, Examples::Given(x, labels), count, &step).unwrap();
        let (values, gradients) = (apart(&answers, &said), apart(&state.mean, &gradient));
        // The gradient of a logarithm is as large as what it is of is small: rounding in a channel that hardly swings counts more.
        let tolerance = if config.pool == Pool::LogRms { 3e-4 } else { 1e-5 };
        assert!(values < 1e-5 && gradients < tolerance, "case {case}: {values:e} {gradients:e} {config:?}");
        assert!(
            (f64::from(losses[0]) - value).abs() < 1e-5 * value.abs().max(1.0),
            "case {case}: {losses:?} {value}"
        );
    }
}

#[cube(launch)]
fn words_of(asked: &[u32], said: &mut [u32]) {
    let at = UNIT_POS as usize;
    let mut words = Array::<u32>::new(2usize);
    words[0] = asked[4 * at];
    words[1] = asked[4 * at + 1];
    threefry(&mut words, asked[4 * at + 2], asked[4 * at + 3]);
    said[2 * at] = words[0];
    said[2 * at + 1] = words[1];
}

/// Known answers of the authors' own program (Random123, `kat_vectors`).
#[test]
fn random_words_are_the_known_ones() {
    Gpu::open().unwrap();
    let client = cubecl::Device::default().client();
    let pi = [0x243f_6a88, 0x85a3_08d3, 0x1319_8a2e, 0x0370_7344];
    let asked = Room::of(&client, [[0; 4], [u32::MAX; 4], pi].as_flattened());
    let said = Room::empty(&client, 6);
    words_of::launch(&client, CubeCount::Static(1, 1, 1), CubeDim::new_1d(3), asked.arg(), said.arg());
    let bytes = client.read_one(said.handle).unwrap();
    assert_eq!(
        u32::from_bytes(&bytes),
        [0x6b20_0159, 0x99ba_4efe, 0x1cb9_96fc, 0xbb00_2be7, 0xc492_3a9c, 0x483d_f7a0]
    );
}

/// A ramp, cleaned by means over three samples, which leave it; then noise of known level on top.
#[test]
fn drawn_windows_are_recorded_ones_turned_about_under_noise_of_their_label() {
    Gpu::open().unwrap();
    let client = cubecl::Device::default().client();
    let (window, rows) = (50, 4000u32);
    let third = |row: usize, at: usize| {
        let first = row.clamp(1, window - 2) - 1;
        // A line through three samples, so that the ends are left as well.
        let line = [[5.0, 2.0, -1.0], [2.0, 2.0, 2.0], [-1.0, 2.0, 5.0]][row - first];
        (first..first + 3).position(|from| from == at).map_or(0.0, |tap| line[tap] / 6.0)
    };
    let filter: Vec<f64> = (0..window * window).map(|i| third(i / window, i % window)).collect();
    let samples: Vec<f32> = (0..300).map(|i| 9.81 + 0.01 * i as f32).collect();
    let places = vec![[0, 49], [100, 0], [150, 49]];
    let turns = Turns { offset: true, sign: true, reverse: true, grow_share: 0.0, factors: [1.0; 2] };
    let levels = (LevelDraw::Grid(5), [0.1, 0.5]);
    let source = Source::new(window, samples, places, &[filter], levels, turns);
    let chosen: Vec<[u32; 2]> = (0..rows).map(|row| [row % 3, row / 3]).collect();
    let (windows, labels) =
        (Room::empty(&client, rows as usize * window), Room::empty(&client, rows as usize));
    source.draw(&client, &chosen, [3, 4], &windows, &labels, 0);
    let read = |room: Room| f32::from_bytes(&client.read_one(room.handle).unwrap()).to_vec();
    let (windows, labels) = (read(windows), read(labels));
    let (mut flipped, mut turned, mut starts) = (0, 0, std::collections::BTreeSet::new());
    let mut ratio = 0.0;
    for (row, label) in windows.chunks_exact(window).zip(&labels) {
        assert!((1..=5).any(|level| (label - 0.1 * level as f32).abs() < 1e-6), "{label}");
        let mean = row.iter().sum::<f32>() / window as f32;
        flipped += usize::from(mean < 0.0);
        let row: Vec<f32> = row.iter().map(|v| v * mean.signum()).collect();
        // Slope by least squares: its deviation is label / sqrt(sum (t - mean t)^2), and that sum is 10412.
        let slope: f32 = row.iter().enumerate().map(|(t, v)| (t as f32 - 24.5) * v).sum::<f32>() / 10412.5;
        assert!((slope.abs() - 0.01).abs() < 5.0 * label / 102.0, "{slope} {label}");
        turned += usize::from(slope < 0.0);
        let line = |t: usize| mean.abs() + slope.signum() * 0.01 * (t as f32 - 24.5);
        let square = row.iter().enumerate().map(|(t, v)| (v - line(t)).powi(2)).sum::<f32>() / window as f32;
        ratio += square / (label * label) / rows as f32;
        starts.insert(((mean.abs() - 9.81) / 0.01 - 24.5).round() as i32);
    }
    // Deviations: of the counts 32, of the ratio .003; a mean fitted takes a fiftieth.
    assert!((1840..2160).contains(&flipped) && (1500..2500).contains(&turned), "{flipped} {turned}");
    assert!((ratio - 0.98).abs() < 0.02, "{ratio}");
    assert!(starts.len() > 100, "{starts:?}");
    // White: neighbours do not go together.
    let mut product = 0.0;
    for (row, label) in windows.chunks_exact(window).zip(&labels).filter(|(_, label)| **label > 0.4) {
        let second: Vec<f32> = row.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]) / label).collect();
        product += second.windows(2).map(|w| w[0] * w[1]).sum::<f32>() / second.len() as f32;
    }
    let loud = labels.iter().filter(|label| **label > 0.4).count() as f32;
    // Of second differences of white noise neighbours have the covariance -4.
    assert!((product / loud + 4.0).abs() < 0.1, "{}", product / loud);
}

/// Asked of this very test in a process of its own, for a card is looked for once a process.
#[cfg(target_os = "linux")]
#[test]
fn without_a_driver_what_was_looked_for_is_said() {
    const ALONE: &str = "DPN_TEST_WITHOUT_A_DRIVER";
    if std::env::var_os(ALONE).is_some() {
        println!("{}", Gpu::open().unwrap_err());
        return;
    }
    let mut alone = std::process::Command::new(std::env::current_exe().unwrap());
    alone.args(["--exact", "tests::without_a_driver_what_was_looked_for_is_said", "--nocapture"]);
    let drivers = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES", "__EGL_VENDOR_LIBRARY_FILENAMES", ALONE];
    let said = alone.envs(drivers.map(|name| (name, "/none"))).output().unwrap();
    let said = String::from_utf8(said.stdout).unwrap();
    assert!(said.contains("no GPU was found through Vulkan, Metal, DirectX or OpenGL: No adapter"), "{said}");
}

#[test]
fn a_window_and_a_batch_that_do_not_go_in_are_errors_that_name_the_card_and_leave_the_state() {
    let gpu = Gpu::open().unwrap();
    let refused = |error: GpuError, expected: &str| {
        assert!(matches!(&error, GpuError::Memory { what, .. } if *what == expected), "{error}");
        assert!(error.to_string().starts_with(gpu.adapter()), "{error}");
    };
    let training = |config| Training::new(&gpu, config, Loss::Mse, AdamConfig::default(), 0.0);
    let weights = |config| initial_parameters(config, &Stream::new(13));
    let long = ProNetConfig {
        window: 2_000_000,
        channels: vec![200],
        kernels: vec![3],
        strides: vec![1],
        paddings: vec![0],
        ..ProNetConfig::default()
    };
    let answers = training(&long).answers(&weights(&long), vec![0.0; long.window]);
    refused(answers.unwrap_err(), "a window");

    let usual = ProNetConfig::default();
    let (window, mut same) = (usual.window, vec![0.0; usual.window.pow(2)]);
    same.iter_mut().step_by(window + 1).for_each(|diagonal| *diagonal = 1.0);
    let turns = Turns { offset: false, sign: false, reverse: false, grow_share: 0.0, factors: [1.0; 2] };
    let levels = (LevelDraw::Uniform, [0.1, 0.5]);
    let source = Source::new(window, vec![0.0; window], vec![[0, 0]], &[same], levels, turns);
    // A gibibyte of samples and a window.
    let rows = vec![[0, 0]; (1 << 28) / window + 1];
    let batch = rows.len();
    let examples = Examples::Drawn { source: std::sync::Arc::new(source), rows, key: [0, 0] };
    let mut state = State::new(weights(&usual));
    let before = state.clone();
    let step = [Step { number: 1, rate: 1e-3, keep: 0.0 }];
    let taken = training(&usual).steps(&mut state, examples, batch, &step);
    refused(taken.unwrap_err(), "a batch");
    assert!(state == before);
}
