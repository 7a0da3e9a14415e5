//! Whether the published stamps keep the time of the IMU's: how late the poses are, window by window.
//!
//! One delay is part of the adjustment. What the rotations are still off by along the body's turning says how much more of it each window wants:
//! with `J` the derivative of a pose's rotation residual by the delay and `e` what the rotation is off by, `d = -sum J^T e / sum J^T J`.

use crate::adjust::Adjusted;
use crate::layout::DELAY;
use crate::problem::{Problem, Role};
use nalgebra::Vector3;
use serde::Serialize;

/// Length of a window \[s\].
const WINDOW_S: f64 = 10.0;
/// A window in which the body turns less tells nothing \[rad/s, root mean square\].
const LEAST_TURNING: f64 = 0.15;
/// A window that is cut shorter than this tells little \[s\].
const LEAST_S: f64 = 0.5 * WINDOW_S;
/// Windows that are farther apart are of two clocks \[ms\]. Those of ten EuRoC sequences and of two TUM-VI rooms are at most 4 ms apart, those of V2_03 9.5 ms,
/// whose published poses are known to disagree with the IMU.
const APART_MS: f64 = 8.0;

/// How late the published poses are in a window.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct WindowDelay {
    /// Begin, seconds after the first sample.
    pub from_s: f64,
    /// End.
    pub to_s: f64,
    /// Published stamps are so much later than the IMU's \[ms\].
    pub delay_ms: f64,
}

/// The delay of every window in which the body turns, from what every published pose is off by.
pub(crate) fn window_delays(
    problem: &Problem<'_>,
    adjusted: &Adjusted,
    errors: &[(Vector3<f64>, Vector3<f64>)],
) -> Vec<WindowDelay> {
    let first = problem.samples[0].t;
    let delay_s = adjusted.estimate.frames.delay_s;
    let terms = problem.terms(&adjusted.estimate);
    let used = terms.iter().zip(errors).zip(&problem.published).filter(|(_, p)| p.role == Role::Used);
    let mut windows: Vec<(WindowDelay, [f64; 2], usize)> = Vec::new();
    for (((_, term), (_, rotation)), published) in used {
        let at = published.pose.t.seconds_since(first) - delay_s;
        if windows.last().is_none_or(|(window, ..)| at - window.from_s > WINDOW_S) {
            windows.push((WindowDelay { from_s: at, to_s: at, delay_ms: 0.0 }, [0.0; 2], 0));
        }
        let (window, [along, square], count) = windows.last_mut().expect("one was just pushed");
        let by_delay = term.by_constants.fixed_view::<3, 1>(3, DELAY);
        *along -= by_delay.dot(rotation);
        *square += by_delay.norm_squared();
        (window.to_s, *count) = (at, *count + 1);
    }
    let told = |(window, [along, square], count): (WindowDelay, [f64; 2], usize)| {
        let turning = (square / count as f64).sqrt();
        (window.to_s - window.from_s >= LEAST_S && turning > LEAST_TURNING)
            .then(|| WindowDelay { delay_ms: 1e3 * (delay_s + along / square), ..window })
    };
    windows.into_iter().filter_map(told).collect()
}

/// What is to be said where the windows' delays are those of no one clock.
pub(crate) fn unsteady(windows: &[WindowDelay]) -> Option<String> {
    let by_delay = |a: &&WindowDelay, b: &&WindowDelay| a.delay_ms.total_cmp(&b.delay_ms);
    let (least, most) = (windows.iter().min_by(by_delay)?, windows.iter().max_by(by_delay)?);
    (most.delay_ms - least.delay_ms > APART_MS).then(|| {
        let word = |window: &WindowDelay| {
            let WindowDelay { from_s, to_s, delay_ms } = window;
            let word = if *delay_ms > 0.0 { "late" } else { "early" };
            format!("{word} by {:.1} ms from {from_s:.0} to {to_s:.0} s", delay_ms.abs())
        };
        format!(
            "the published stamps do not keep the IMU's time: {}, {}; one delay was taken off, so poses are wrong by what they move meanwhile: mend the stamps, or cut the recording where they step",
            word(least),
            word(most)
        )
    })
}
