//! How often the truth lies in the interval of [`RestNoise`], over simulated logs of every kind: `cargo run --release -p dpn-probe --example rest_coverage [SEED]`.

use dpn_core::signal::stats::median;
use dpn_core::{ImuRecording, ImuSample, Stamp};
use dpn_probe::phases::phases;
use dpn_probe::rest_noise::RestNoise;
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use std::f64::consts::{FRAC_1_SQRT_2, PI, TAU};

const LOGS: usize = 300;
const ANALOG: usize = 8;

/// What a log is simulated with.
#[derive(Debug)]
struct Kind {
    hz: f64,
    seconds: f64,
    density: f64,
    order: usize,
    corner: f64,
    /// The filter runs at eight times the log's rate.
    analog: bool,
    /// Samples are means of so many at a higher rate.
    averaged: usize,
    /// Step over the filtered noise's deviation.
    step: f64,
    held: bool,
    lines: usize,
    lost: f64,
    walk: f64,
    drift: f64,
}

impl Kind {
    fn drawn(rng: &mut ChaCha8Rng) -> Self {
        let pick = |rng: &mut ChaCha8Rng, of: &[f64]| of[rng.random_range(0..of.len())];
        let hz = pick(rng, &[50.0, 77.0, 100.0, 200.0, 256.0, 400.0, 500.0, 1000.0]);
        let density = 10f64.powf(rng.random_range(-4.0..-2.0));
        let order = rng.random_range(0..3);
        let mut corner = pick(rng, &[5.0, 10.0, 20.0, 42.0, 98.0, 188.0]);
        let analog = order > 0 && rng.random();
        if !analog {
            corner = f64::min(corner, 0.3 * hz);
        }
        let chance = |rng: &mut ChaCha8Rng, share: f64| rng.random::<f64>() < share;
        Self {
            hz,
            seconds: pick(rng, &[20.0, 30.0, 60.0, 120.0]),
            density,
            order,
            corner,
            analog,
            averaged: if !analog && chance(rng, 0.15) { rng.random_range(2..6) } else { 1 },
            step: if chance(rng, 0.4) { 10f64.powf(rng.random_range(-1.5..0.2)) } else { 0.0 },
            held: chance(rng, 0.1),
            lines: if chance(rng, 0.25) { 1 } else { 0 },
            lost: if chance(rng, 0.2) { 0.01 } else { 0.0 },
            walk: density * 10f64.powf(rng.random_range(-3.0..-1.0)),
            drift: density * rng.random_range(0.0..0.3),
        }
    }

    /// One axis, and the density that it has below the corner: what folds back from above half the rate counts.
    fn axis(&self, rng: &mut ChaCha8Rng) -> (Vec<f64>, f64) {
        let mut normal = || -> f64 { StandardNormal.sample(rng) };
        let up = if self.analog { ANALOG } else { self.averaged };
        let inner = self.hz * up as f64;
        let k = (PI * self.corner / inner).tan();
        let (b, a) = match self.order {
            0 => ([1.0, 0.0, 0.0], [0.0, 0.0]),
            1 => {
                let g = 1.0 / (1.0 + k);
                ([k * g, k * g, 0.0], [(k - 1.0) * g, 0.0])
            }
            _ => {
                let g = 1.0 / (1.0 + k / FRAC_1_SQRT_2 + k * k);
                (
                    [k * k * g, 2.0 * k * k * g, k * k * g],
                    [2.0 * (k * k - 1.0) * g, (1.0 - k / FRAC_1_SQRT_2 + k * k) * g],
                )
            }
        };
        let count = (self.seconds * self.hz) as usize;
        let settle = (2.0 * inner) as usize / up;
        let (mut x, mut y) = ([0.0; 2], [0.0; 2]);
        let (mut walk, mut drift) = (0.0, [0.0; 6]);
        let mut values = Vec::with_capacity(count);
        for i in 0..count + settle {
            let mut mean = 0.0;
            for j in 0..up {
                let now = self.density * inner.sqrt() * normal();
                let out = b[0] * now + b[1] * x[0] + b[2] * x[1] - a[0] * y[0] - a[1] * y[1];
                (x, y) = ([now, x[0]], [out, y[0]]);
                if self.analog {
                    mean = if j + 1 == up { out } else { 0.0 };
                } else {
                    mean += out / up as f64;
                }
            }
            walk += self.walk / self.hz.sqrt() * normal();
            for (decade, state) in drift.iter_mut().enumerate() {
                let kept = (-1.0 / (self.hz * 10f64.powi(decade as i32 - 2))).exp();
                *state = kept * *state + (1.0 - kept * kept).sqrt() * self.drift * normal();
            }
            if i >= settle {
                values.push(mean + walk + drift.iter().sum::<f64>());
            }
        }
        let mut folded = 1.0;
        if self.analog {
            for m in 1..=ANALOG / 2 {
                let tan = (PI * m as f64 / ANALOG as f64).tan();
                let gain = if tan > 1e9 { 0.0 } else { 1.0 / (1.0 + (tan / k).powi(2 * self.order as i32)) };
                folded += if 2 * m == ANALOG { gain } else { 2.0 * gain };
            }
        }
        (values, self.density * f64::sqrt(folded))
    }

    /// The frequency below which the filter and the means leave nine tenths of the power.
    fn plateau(&self) -> f64 {
        let filter = match self.order {
            0 => f64::INFINITY,
            order => self.corner * (1.0 / 9.0f64).powf(0.5 / order as f64),
        };
        let means = if self.averaged > 1 { 0.177 * self.hz } else { 0.5 * self.hz };
        filter.min(means)
    }

    /// Who knows the shape still needs so many independent values of a plateau for an interval of 95 % that is a factor of 1.2 wide: the deviation of a level from n
    /// of them is 1 / (2 sqrt(n)) of it.
    fn plateau_is_seen(&self) -> bool {
        self.plateau() * self.seconds >= (1.96 / 1.2f64.ln()).powi(2)
    }

    fn log(&self, rng: &mut ChaCha8Rng) -> (ImuRecording, f64) {
        let axes: Vec<(Vec<f64>, f64)> = (0..3).map(|_| self.axis(rng)).collect();
        let band = if self.order == 0 { 0.5 * self.hz } else { self.corner.min(0.5 * self.hz) };
        let noise = self.density * band.sqrt();
        let step = self.step * noise;
        let line: f64 = rng.random_range(0.02..0.45) * self.hz;
        let spread = if self.held { 1.6 } else { 1.0 };
        let rows = (axes[0].0.len() as f64 * spread) as usize;
        let mut samples = Vec::new();
        for i in 0..rows {
            let at = ((i as f64 / spread) as usize).min(axes[0].0.len() - 1);
            let value = |axis: usize| {
                let hum = self.lines as f64 * 0.7 * noise * (TAU * line * at as f64 / self.hz).sin();
                let v = axes[axis].0[at] + hum + 0.3;
                if step > 0.0 { (v / step).round() * step } else { v }
            };
            let accel = [0, 1, 2].map(value);
            if rng.random::<f64>() >= self.lost {
                let ns = (i as f64 / (self.hz * spread) * 1e9) as i64;
                let normal: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(rng));
                samples.push(ImuSample { t: Stamp::from_ns(ns), gyro: normal.map(|v| 1e-3 * v), accel });
            }
        }
        (ImuRecording::new(samples).expect("a simulated log"), axes[0].1)
    }
}

fn main() {
    let seed = std::env::args().nth(1).map_or(1, |seed| seed.parse().expect("a number"));
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let (mut all, mut inside, mut off, mut unknown, mut widths) = (0, 0, 0, 0, Vec::new());
    let (mut seen, mut seen_wide) = (0, 0);
    for i in 0..LOGS {
        let kind = Kind::drawn(&mut rng);
        let (log, truth) = kind.log(&mut rng);
        let stretches = phases(&log).expect("in memory");
        let Some(found) = RestNoise::of(&log, &stretches).expect("in memory") else {
            println!("{i}: no rest: {kind:?}");
            unknown += 3;
            continue;
        };
        for axis in &found.sensors[0].axes {
            all += 1;
            let Some(density) = axis.as_ref().and_then(|a| a.density) else {
                unknown += 1;
                if axis.as_ref().is_some_and(|a| a.below < truth) {
                    println!("{i}: bound below the truth: {kind:?} {axis:?}");
                }
                continue;
            };
            let ratio = density.value / truth;
            inside += usize::from((density.low..=density.high).contains(&truth));
            widths.push(density.width());
            if kind.plateau_is_seen() {
                seen += 1;
                if density.width() > 1.2 {
                    seen_wide += 1;
                    println!(
                        "{i}: width {:.3}, {:.0} values: {kind:?}",
                        density.width(),
                        kind.plateau() * kind.seconds
                    );
                }
            }
            if !(1.0 / 1.3..1.3).contains(&ratio) {
                off += 1;
                println!("{i}: {ratio:.3}: {kind:?} {axis:?}");
            }
        }
    }
    let known = widths.len();
    println!(
        "{known} axes known of {all}, {unknown} unknown: truth inside {:.1} %, width {:.3} (median), {} wider than 1.2 ({seen_wide} of the {seen} whose plateau is seen), {off} off by 1.3",
        100.0 * inside as f64 / known as f64,
        median(&widths),
        widths.iter().filter(|w| **w > 1.2).count()
    );
}
