//! What levels of noise are worth as the covariance of inertial residuals, by the length of a span.
//!
//! Over a span the samples are pre-integrated from the true state under one bias of the whole course, and the end is held against the true one: position, rotation, velocity, nine numbers. Their
//! covariance is a deviation of the accelerometer and one of the gyroscope, squared, times what one of each makes of the span. A level from residuals is the one whose squares are the mean
//! ones: the gyroscope's by the rotations, the accelerometer's by positions and velocities. True velocities are differences of true positions.

use crate::affine::pull;
use crate::course::Course;
use dpn_core::geometry::so3;
use dpn_core::signal::stats::median_of;
use dpn_core::{GRAVITY, ImuNoise};
use dpn_vio::preint::{NoisySample, Preintegration, PreintegrationConfig};
use dpn_vio::state::{ACCEL_BIAS, GYRO_BIAS, POSITION, ROTATION, VELOCITY};
use dpn_vio::{ImuBias, NavState};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use serde::Serialize;

/// Lengths of spans \[s\].
pub const SPANS_S: [f64; 4] = [0.1, 0.2, 0.5, 1.0];
/// Residuals of so many seconds before a span are what `self` is told from.
const RECENT_S: f64 = 5.0;
/// A velocity is a difference over so many samples to both sides.
const BESIDE: usize = 5;
/// Residuals of a span.
const DIM: usize = 9;
/// A chi-square variable of nine degrees of freedom is smaller with 95 %.
const CHI_SQUARE: f64 = 16.919;
/// Rounds of the bias: residuals are nearly linear in it.
const ROUNDS: usize = 2;

/// Deviations of one sample, accelerometer \[m/s^2\] and gyroscope \[rad/s\].
pub type Levels = [f64; 2];

/// What somebody says of a course's noise, at each sample of it.
pub struct Said {
    /// Who.
    pub name: String,
    /// At each sample.
    pub levels: Vec<Levels>,
}

/// What levels are worth over spans of one length.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpanScore {
    /// Where the levels come from.
    pub name: String,
    /// Length of a span \[s\].
    pub span_s: f64,
    /// Mean negative logarithm of the likelihood of nine residuals in SI units.
    pub nll: f64,
    /// Mean normalised square over its nine degrees of freedom.
    pub nees: f64,
    /// Share of the spans within the 95 % ellipsoid.
    pub inside: f64,
    /// How many spans.
    pub spans: usize,
}

/// One span: residual, and its covariance for a deviation of 1 of each sensor.
struct Span {
    /// Its first sample.
    from: usize,
    end_s: f64,
    residual: SVector<f64, DIM>,
    by: [SMatrix<f64, DIM, DIM>; 2],
}

/// Spans of one length.
struct Length {
    samples: usize,
    spans: Vec<Span>,
}

/// The residuals of a course, by the length of a span, and what is said of them.
pub struct Residuals {
    lengths: Vec<Length>,
    said: Vec<Said>,
}

impl Residuals {
    /// Of `course`; of each who says something, the levels at its samples.
    pub fn of(course: &Course, said: Vec<Said>) -> Self {
        Self { lengths: SPANS_S.iter().map(|span_s| spans(course, *span_s)).collect(), said }
    }

    /// Scores of what was said, as it is and by the factor that suits the training sequences, of the mean levels of those of the same platform (`own`), of the `other` ones and of both, and of
    /// recent residuals.
    pub fn scores(&self, own: &[&Self], other: &[&Self]) -> Vec<SpanScore> {
        let all = [own, other].concat();
        let mut scores = Vec::new();
        for (i, length) in self.lengths.iter().enumerate().filter(|(_, length)| !length.spans.is_empty()) {
            let spans = &length.spans;
            let mut add =
                |name: &str, of: &dyn Fn(usize) -> Levels| scores.push(score(name, SPANS_S[i], spans, of));
            for said in &self.said {
                let say = |at: usize| said.over(spans[at].from, length.samples);
                add(&said.name, &say);
                let factor = levels(all.iter().flat_map(|one| one.said_at(&said.name, i)));
                // Of a constant that is the constant of the training sequences.
                let varies = said.levels.iter().any(|levels| *levels != said.levels[0]);
                if varies && factor.iter().all(|factor| *factor > 0.0) {
                    add(&format!("{}, scaled", said.name), &|at| product(say(at), factor));
                }
            }
            let constants = [
                ("one constant", &all[..]),
                ("a constant a platform", own),
                // Where nobody says which platform is whose, there are no others.
                ("a constant of the other platforms", if own.is_empty() { &[] } else { other }),
            ];
            for (name, sequences) in constants {
                let constant = levels(
                    sequences.iter().flat_map(|one| &one.lengths[i].spans).map(|span| (span, [1.0; 2])),
                );
                if constant.iter().all(|level| *level > 0.0) {
                    add(name, &|_| constant);
                }
            }
            let mean = |spans: &[Span]| levels(spans.iter().map(|span| (span, [1.0; 2])));
            let start = spans.partition_point(|span| span.end_s < RECENT_S).max(1);
            add("residuals of the last 5 s", &|at| {
                let from = spans[..at].partition_point(|span| span.end_s < spans[at].end_s - RECENT_S);
                // The first seconds are told by themselves: nothing came before.
                mean(if at < start { &spans[..start] } else { &spans[from.min(at - 1)..at] })
            });
            let oracle = mean(spans);
            add("oracle, a constant a sequence", &|_| oracle);
        }
        scores
    }

    /// The spans of one length with what `name` says of each.
    fn said_at(&self, name: &str, length: usize) -> impl Iterator<Item = (&Span, Levels)> {
        let Length { samples, spans } = &self.lengths[length];
        let said = self.said.iter().find(|said| said.name == name);
        said.into_iter()
            .flat_map(move |said| spans.iter().map(move |span| (span, said.over(span.from, *samples))))
    }
}

impl Said {
    /// The root of the mean square over so many samples.
    fn over(&self, from: usize, samples: usize) -> Levels {
        let part = &self.levels[from..from + samples];
        [0, 1].map(|sensor| {
            (part.iter().map(|level| level[sensor].powi(2)).sum::<f64>() / samples as f64).sqrt()
        })
    }
}

fn product(a: Levels, b: Levels) -> Levels {
    [a[0] * b[0], a[1] * b[1]]
}

fn score(name: &str, span_s: f64, spans: &[Span], levels: &dyn Fn(usize) -> Levels) -> SpanScore {
    let (mut nll, mut nees, mut inside) = (0.0, 0.0, 0_usize);
    for (i, span) in spans.iter().enumerate() {
        let [accel, gyro] = levels(i).map(|level| level * level);
        let covariance = span.by[0] * accel + span.by[1] * gyro;
        let Some(factor) = covariance.cholesky() else { continue };
        let square = span.residual.dot(&factor.solve(&span.residual));
        let log_det = 2.0 * factor.l_dirty().diagonal().map(f64::ln).sum();
        nll += 0.5 * (square + log_det + DIM as f64 * std::f64::consts::TAU.ln());
        nees += square / DIM as f64;
        inside += usize::from(square < CHI_SQUARE);
    }
    let n = spans.len() as f64;
    SpanScore {
        name: name.to_owned(),
        span_s,
        nll: nll / n,
        nees: nees / n,
        inside: inside as f64 / n,
        spans: spans.len(),
    }
}

/// By what factor the residuals' mean squares are those of the levels beside each.
fn levels<'a>(spans: impl IntoIterator<Item = (&'a Span, Levels)>) -> Levels {
    let (mut sums, mut count) = ([0.0; 2], 0_usize);
    for (span, [accel, gyro]) in spans {
        count += 1;
        let turn: Vector3<f64> = span.residual.fixed_rows::<3>(ROTATION).into();
        let by: Matrix3<f64> = span.by[1].fixed_view::<3, 3>(ROTATION, ROTATION).into();
        sums[1] += by.cholesky().map_or(0.0, |by| turn.dot(&by.solve(&turn))) / (3.0 * gyro * gyro);
        let places = [POSITION, POSITION + 1, POSITION + 2, VELOCITY, VELOCITY + 1, VELOCITY + 2];
        let moved = SVector::<f64, 6>::from_fn(|i, _| span.residual[places[i]]);
        let by = SMatrix::<f64, 6, 6>::from_fn(|i, j| span.by[0][(places[i], places[j])]);
        sums[0] += by.cholesky().map_or(0.0, |by| moved.dot(&by.solve(&moved))) / (6.0 * accel * accel);
    }
    sums.map(|sum| (sum / count.max(1) as f64).sqrt())
}

/// The spans of a course end to end, under the one bias that leaves the least turns and velocities.
fn spans(course: &Course, span_s: f64) -> Length {
    let samples = (span_s * course.rate.hz()).round() as usize;
    let (mut bias, mut out) = (ImuBias::zero(), Vec::new());
    for round in 0..=ROUNDS {
        let (mut end_s, mut slopes) = (0.0, Vec::new());
        out.clear();
        for from in (BESIDE..course.len().saturating_sub(samples + BESIDE)).step_by(samples) {
            end_s += course.step_s[from..from + samples].iter().sum::<f64>();
            if let Some((span, by_bias)) = span(course, from, samples, &bias, end_s, round == ROUNDS) {
                slopes.push((span.residual.fixed_rows::<6>(ROTATION).into_owned(), by_bias));
                out.push(span);
            }
        }
        if round == ROUNDS {
            break;
        }
        // Turns alone say the gyroscope's: velocities, far noisier, would blur it.
        let block = |by: &SMatrix<f64, 6, 6>, row: usize, column: usize| -> Matrix3<f64> {
            by.fixed_view::<3, 3>(row, column - DIM).into()
        };
        let turns = slopes.iter().map(|(r, by)| (r.fixed_rows::<3>(0).into(), block(by, 0, GYRO_BIAS)));
        let gyro = solved(&turns.collect::<Vec<_>>());
        let velocities = slopes
            .iter()
            .map(|(r, by)| (r.fixed_rows::<3>(3) - block(by, 3, GYRO_BIAS) * gyro, block(by, 3, ACCEL_BIAS)));
        bias.accel += solved(&velocities.collect::<Vec<_>>());
        bias.gyro += gyro;
    }
    Length { samples, spans: out }
}

/// What times the slopes leaves least of the values, far ones pulling less; nothing where that is not known.
fn solved(rows: &[(Vector3<f64>, Matrix3<f64>)]) -> Vector3<f64> {
    let typical = median_of(rows.iter().map(|(r, _)| r.norm())).unwrap_or(0.0);
    let (mut h, mut g) = (Matrix3::zeros(), Vector3::zeros());
    for (r, by) in rows {
        let weight = pull(r.norm(), typical);
        h += weight * by.transpose() * by;
        g += weight * by.transpose() * r;
    }
    h.cholesky().map_or(Vector3::zeros(), |h| h.solve(&g))
}

/// One span and its turn's and velocity's derivatives by the biases; covariances where they are asked for.
fn span(
    course: &Course,
    from: usize,
    samples: usize,
    bias: &ImuBias,
    end_s: f64,
    with_covariance: bool,
) -> Option<(Span, SMatrix<f64, 6, 6>)> {
    let to = from + samples;
    course.turn(from - BESIDE, to + BESIDE)?;
    let state = |i: usize| {
        let at = |i: usize| Some((*course.truth.get(i)?)?.translation.vector);
        let seconds: f64 = course.step_s[i - BESIDE..i + BESIDE].iter().sum();
        let vel_in_world = (at(i + BESIDE)? - at(i - BESIDE)?) / seconds;
        Some(NavState { world_from_body: course.truth[i]?, vel_in_world, bias: *bias })
    };
    let (before, after) = (state(from)?, state(to)?);
    let integrated = |accel: f64, gyro: f64| {
        let noise = ImuNoise::from_values([accel; 3], [gyro; 3]).expect("0 and 1 are deviations");
        let mut samples = course.samples(from).map(|sample| NoisySample { sample, noise });
        let first = samples.next().expect("a span has samples");
        let mut whole = Preintegration::new(PreintegrationConfig::default(), *bias, first);
        samples.take(to - from).for_each(|sample| whole.push(sample));
        whole
    };
    let accel = integrated(1.0, 0.0);
    let (delta, seconds) = (accel.delta(), accel.duration());
    let body_from_world = before.world_from_body.rotation.inverse();
    let gravity_in_world = Vector3::new(0.0, 0.0, -GRAVITY);
    let moved = after.world_from_body.translation.vector - before.world_from_body.translation.vector;
    let mut residual = SVector::<f64, DIM>::zeros();
    let position = body_from_world
        * (moved - before.vel_in_world * seconds - gravity_in_world * (0.5 * seconds * seconds));
    residual.fixed_rows_mut::<3>(POSITION).copy_from(&(position - delta.position));
    let turn = body_from_world * after.world_from_body.rotation;
    residual.fixed_rows_mut::<3>(ROTATION).copy_from(&so3::log(&(delta.rotation.inverse() * turn)));
    let velocity = body_from_world * (after.vel_in_world - before.vel_in_world - gravity_in_world * seconds);
    residual.fixed_rows_mut::<3>(VELOCITY).copy_from(&(velocity - delta.velocity));
    let block = |of: &Preintegration| of.covariance().fixed_view::<DIM, DIM>(0, 0).into_owned();
    let by =
        if with_covariance { [block(&accel), block(&integrated(0.0, 1.0))] } else { [SMatrix::zeros(); 2] };
    let by_bias = accel.jacobian().fixed_view::<6, 6>(ROTATION, 0).into_owned();
    Some((Span { from, end_s, residual, by }, by_bias))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::course::simulated;
    use dpn_core::random::Stream;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn levels_that_were_added_come_back_and_are_consistent_over_every_span() {
        let (accel, gyro) = (0.2, 0.01);
        let mut course = simulated(120.0, Matrix3::identity(), Vector3::new(0.01, 0.02, -0.03), gyro);
        let mut rng = Stream::new(8).named("accel").rng();
        for force in &mut course.accel {
            let white = Vector3::from_fn(|_, _| -> f64 { StandardNormal.sample(&mut rng) });
            *force += accel * white + Vector3::repeat(0.1);
        }
        // Somebody says half of it for half of the time, who is right about no level and, by one factor, at least consistent.
        let half = |i: usize| [0.5 * accel, if i < 9_000 { 0.5 * gyro } else { gyro }];
        let said = |name: &str, of: &dyn Fn(usize) -> Levels| Said {
            name: name.into(),
            levels: (0..course.len()).map(of).collect(),
        };
        let residuals = Residuals::of(&course, vec![said("right", &|_| [accel, gyro]), said("half", &half)]);
        let scores = residuals.scores(&[], &[&residuals]);
        for score in &scores {
            assert!((score.nees > 1.8) == (score.name == "half"), "{score:?}");
            assert!(score.name == "half" || (0.85..1.15).contains(&score.nees), "{score:?}");
            assert!(score.name.starts_with("half") || (0.9..0.99).contains(&score.inside), "{score:?}");
        }
        let found = levels(residuals.lengths[1].spans.iter().map(|span| (span, [1.0; 2])));
        assert!((found[0] / accel - 1.0).abs() < 0.1 && (found[1] / gyro - 1.0).abs() < 0.1, "{found:?}");
        let nll = |name: &str| scores.iter().find(|s| s.name == name && s.span_s == 1.0).unwrap().nll;
        assert!(
            nll("oracle, a constant a sequence") < nll("half, scaled") && nll("half, scaled") < nll("half")
        );
        assert!(scores.iter().all(|score| !score.name.starts_with("a constant")));
    }
}
