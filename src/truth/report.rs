//! What a reconciliation found, and how far to trust it where.

use crate::adjust::Adjusted;
use crate::align::Guess;
use crate::clock::{WindowDelay, unsteady, window_delays};
use crate::components::Levels;
use crate::config::TruthConfig;
use crate::layout::{DELAY, LEVER, MOUNT, TILT};
use crate::problem::{Problem, Role};
use crate::screen::{Segment, errors};
use dpn_core::geometry::so3;
use serde::Serialize;

/// A number and its deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Estimated<T> {
    /// The number.
    pub value: T,
    /// Its standard deviation.
    pub std: T,
}

/// Where the poses of a span come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Trust {
    /// Published poses and samples agree.
    Reconciled,
    /// Over a gap of published poses; the samples alone lead, held at both ends.
    Bridged,
    /// Not written: known too badly.
    LeftOut,
}

/// A stretch of one kind of trust.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Span {
    /// Begin, seconds after the first sample.
    pub from_s: f64,
    /// End.
    pub to_s: f64,
    /// Where its poses come from.
    pub trust: Trust,
    /// The largest deviation of position in it, root of the mean over the axes \[m\].
    pub position_std_m: f64,
    /// The same of the rotation \[deg\].
    pub rotation_std_deg: f64,
    /// Why published poses in it were not used.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub why: Option<&'static str>,
}

/// How well poses that were kept out are predicted, each the mean of those beside a key.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct HeldOut {
    /// How many.
    pub poses: usize,
    /// Root mean square of the position's error, an axis \[m\].
    pub position_m: f64,
    /// The same of the rotation \[deg\].
    pub rotation_deg: f64,
    /// The position's error over the deviation it should have, root mean square; 1 is right.
    pub position_whitened: f64,
    /// The same of the rotation.
    pub rotation_whitened: f64,
}

/// What was found.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Correlation of the gyro's and the published absolute rates; nothing where the body hardly turns.
    pub rate_correlation: Option<f64>,
    /// A published stamp is so much later than the IMU's of the same pose \[ms\].
    pub delay_ms: Estimated<f64>,
    /// Rotation vector of `body_from_published_body` \[deg\].
    pub mount_deg: Estimated<[f64; 3]>,
    /// The published origin in the IMU's frame \[mm\].
    pub lever_mm: Estimated<[f64; 3]>,
    /// Angle between the published world's z axis and gravity's \[deg\].
    pub tilt_deg: Estimated<f64>,
    /// How long published poses were smoothed over, as the deviation of a Gaussian \[ms\]; negative where they were sharpened.
    pub blur_ms: f64,
    /// Which of delay, mount, lever, tilt and blur are zero as far as can be told, and are held there.
    pub held: Vec<&'static str>,
    /// How noisy both are, by their disagreement.
    pub levels: Levels,
    /// Redundancy of every group of residuals, in the levels' order.
    pub redundancy: [f64; 8],
    /// What published positions are off by, root mean square, an axis \[mm\].
    pub published_position_error_mm: f64,
    /// The same of rotations \[deg\].
    pub published_rotation_error_deg: f64,
    /// Published poses.
    pub poses: usize,
    /// Those that were used.
    pub used: usize,
    /// Of those kept out on purpose.
    pub held_out: Option<HeldOut>,
    /// Adjustments made.
    pub iterations: usize,
    /// Whether the last one changed nothing any more.
    pub settled: bool,
    /// How late the published poses are, window by window, where the body turns.
    pub window_delays: Vec<WindowDelay>,
    /// How far to trust it where.
    pub spans: Vec<Span>,
    /// What a reader should know.
    pub warnings: Vec<String>,
}

/// What a group of constants is called.
fn name(at: usize) -> &'static str {
    match at {
        DELAY => "delay",
        MOUNT => "mount",
        LEVER => "lever",
        TILT => "tilt",
        _ => "blur",
    }
}

/// Seconds of a blur constant, which is half a variance, with its sign.
fn blur_ms(half_variance: f64) -> f64 {
    1e3 * (2.0 * half_variance.abs()).sqrt().copysign(half_variance)
}

pub(crate) fn report(
    problem: &Problem<'_>,
    adjusted: &Adjusted,
    guess: &Guess,
    deviations: &[(f64, f64)],
    left_out: &[Segment],
    config: &TruthConfig,
) -> Report {
    let frames = &adjusted.estimate.frames;
    let std = |at: usize| adjusted.covariance.constants[(at, at)].sqrt();
    let three = |at: usize, scale: f64| [0, 1, 2].map(|i| scale * std(at + i));
    let mount = so3::log(&frames.body_from_published_body);
    let up = frames.published_world_from_world * nalgebra::Vector3::z();
    let errors = errors(problem, adjusted);
    let used: Vec<_> =
        errors.iter().zip(&problem.published).filter(|(_, p)| p.role == Role::Used).map(|(e, _)| e).collect();
    let rms = |sum: f64| (sum / (3.0 * used.len().max(1) as f64)).sqrt();
    let found = &adjusted.found;
    let mut report = Report {
        rate_correlation: guess.correlation,
        delay_ms: Estimated { value: 1e3 * frames.delay_s, std: 1e3 * std(DELAY) },
        mount_deg: Estimated {
            value: (mount.map(f64::to_degrees)).into(),
            std: three(MOUNT, 1f64.to_degrees()),
        },
        lever_mm: Estimated { value: (frames.lever_in_body * 1e3).into(), std: three(LEVER, 1e3) },
        tilt_deg: Estimated {
            value: up.xy().norm().atan2(up.z).to_degrees(),
            std: std(TILT).hypot(std(TILT + 1)).to_degrees(),
        },
        blur_ms: blur_ms(frames.blur_s2),
        held: problem.held.iter().map(|at| name(*at)).collect(),
        levels: adjusted.levels,
        redundancy: std::array::from_fn(|i| found.rows[i] - found.leverage[i]),
        published_position_error_mm: 1e3 * rms(used.iter().map(|e| e.0.norm_squared()).sum()),
        published_rotation_error_deg: rms(used.iter().map(|e| e.1.norm_squared()).sum()).to_degrees(),
        poses: problem.published.len(),
        used: used.len(),
        held_out: held_out(problem, adjusted, config),
        iterations: adjusted.iterations,
        settled: adjusted.settled,
        window_delays: window_delays(problem, adjusted, &errors),
        spans: spans(problem, adjusted, deviations, left_out, config),
        warnings: Vec::new(),
    };
    report.warnings = warnings(&report, guess);
    report
}

fn held_out(problem: &Problem<'_>, adjusted: &Adjusted, config: &TruthConfig) -> Option<HeldOut> {
    if config.hold_out == 0 {
        return None;
    }
    let mut sums = [0.0; 4];
    let mut poses = 0;
    for (k, blocks) in problem.blocks(&problem.terms(&adjusted.estimate)).iter().enumerate() {
        let Some(term) = &blocks.kept_out else { continue };
        poses += 1;
        let spread = term.spread(&adjusted.covariance, k);
        for row in 0..6 {
            let (half, white) =
                if row < 3 { (0, adjusted.levels.position_std) } else { (1, adjusted.levels.rotation_std) };
            let square = term.residual[row].powi(2);
            sums[half] += square;
            sums[2 + half] += square / (spread[row] + white * white);
        }
    }
    let [position, rotation, position_whitened, rotation_whitened] =
        sums.map(|sum| (sum / (3.0 * f64::from(poses.max(1)))).sqrt());
    Some(HeldOut {
        poses: poses as usize,
        position_m: position,
        rotation_deg: rotation.to_degrees(),
        position_whitened,
        rotation_whitened,
    })
}

fn spans(
    problem: &Problem<'_>,
    adjusted: &Adjusted,
    deviations: &[(f64, f64)],
    left_out: &[Segment],
    config: &TruthConfig,
) -> Vec<Span> {
    let keys = &adjusted.estimate.keys;
    let delay = adjusted.estimate.frames.delay_s;
    let first = problem.samples[0].t;
    let seconds = |k: usize| problem.samples[keys[k].sample].t.seconds_since(first);
    let time = |i: usize| problem.published[i].pose.t.seconds_since(first) - delay;
    let used: Vec<f64> =
        (0..problem.published.len()).filter(|i| problem.published[*i].role == Role::Used).map(time).collect();
    let why = |at: f64| {
        let holds = |s: &&Segment| time(s.poses.start) <= at && at <= time(s.poses.end - 1);
        left_out.iter().find(holds).map(|s| s.why)
    };
    let mut out: Vec<Span> = Vec::new();
    for (k, &(position, rotation)) in deviations.iter().enumerate() {
        let at = seconds(k);
        let after = used.partition_point(|t| *t < at);
        let near = |i: Option<usize>| {
            i.and_then(|i| used.get(i)).is_some_and(|t| (t - at).abs() <= config.longest_gap_s)
        };
        let trust = if position > config.position_limit_m || rotation.to_degrees() > config.rotation_limit_deg
        {
            Trust::LeftOut
        } else if (near(Some(after)) || after == used.len()) && (near(after.checked_sub(1)) || after == 0) {
            Trust::Reconciled
        } else {
            Trust::Bridged
        };
        let why = why(at);
        match out.last_mut().filter(|span| span.trust == trust && span.why == why) {
            Some(span) => {
                span.to_s = at;
                span.position_std_m = span.position_std_m.max(position);
                span.rotation_std_deg = span.rotation_std_deg.max(rotation.to_degrees());
            }
            None => out.push(Span {
                from_s: at,
                to_s: at,
                trust,
                position_std_m: position,
                rotation_std_deg: rotation.to_degrees(),
                why,
            }),
        }
    }
    out
}

/// A delay that is worth a word \[ms\].
const LATE_MS: f64 = 1.0;
/// A turn that is \[deg\].
const TURNED_DEG: f64 = 1.0;
/// A lever that is \[mm\].
const LEVER_MM: f64 = 10.0;

fn warnings(report: &Report, guess: &Guess) -> Vec<String> {
    let mut out = Vec::new();
    let delay = report.delay_ms;
    if delay.value.abs() > LATE_MS && delay.value.abs() > 5.0 * delay.std {
        let word = if delay.value > 0.0 { "late" } else { "early" };
        out.push(format!(
            "the published poses are {word} by {:.2} ms (+- {:.2})",
            delay.value.abs(),
            delay.std
        ));
    }
    out.extend(unsteady(&report.window_delays));
    let turned = report.mount_deg.value.iter().map(|v| v * v).sum::<f64>().sqrt();
    if turned > TURNED_DEG {
        out.push(format!("the published body frame is turned by {turned:.2} deg against the IMU's"));
    }
    if report.tilt_deg.value > TURNED_DEG {
        out.push(format!(
            "the published world is tilted by {:.2} deg against gravity",
            report.tilt_deg.value
        ));
    }
    let lever = report.lever_mm.value.iter().map(|v| v * v).sum::<f64>().sqrt();
    if lever > LEVER_MM {
        out.push(format!("the published origin is {lever:.0} mm away from the IMU"));
    }
    if guess.correlation.is_none() {
        out.push("the body hardly turns: clock and mount cannot be told".to_owned());
    }
    if !report.settled {
        out.push(format!("the levels still change after {} adjustments", report.iterations));
    }
    for span in report.spans.iter().filter(|span| span.trust == Trust::LeftOut || span.why.is_some()) {
        let why = span.why.map_or_else(String::new, |why| format!(": {why}"));
        let what =
            if span.trust == Trust::LeftOut { "nothing is written" } else { "published poses are not used" };
        out.push(format!("{:.1} to {:.1} s: {what}{why}", span.from_s, span.to_s));
    }
    out
}
