//! Tells a clipped signal from one that merely repeats its extreme values.

use crate::imu::{ImuSample, Sensor};
use crate::samples::Samples;
use std::io;

/// Fewest samples of a stay.
const LEAST: usize = 4;
/// A jump, in resolutions.
const JUMP: f64 = 8.0;
/// Samples at an extreme over those beside it that chance does not explain,
const CROWD: usize = 4;
/// on an axis that spans so many resolutions.
const SPAN: f64 = 64.0;
/// Distinct values of an axis that are held at a time: a converter of 16 bits has no more.
const HELD: usize = 1 << 16;

/// An extreme value at which a signal stays.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Plateau {
    /// The value.
    pub value: f64,
    /// Samples of its longest stay.
    pub longest: usize,
    /// Index at which its first stay begins.
    pub first: usize,
}

/// What one axis does at its extremes.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Extremes {
    pub(crate) sensor: Sensor,
    pub(crate) axis: usize,
    low: f64,
    high: f64,
    /// Whether the sensor's values stand on several rows each: a stay is counted in values then.
    held: bool,
    /// Stays at the lowest, then at the highest value.
    pub(crate) plateaus: Vec<Plateau>,
}

impl Extremes {
    fn of(&self, sample: &ImuSample) -> f64 {
        sample.of(self.sensor)[self.axis]
    }

    /// Its only value.
    pub(crate) fn constant(&self) -> Option<f64> {
        (self.low == self.high).then_some(self.low)
    }
}

/// Looks at all axes, the accelerometer's first. A plateau is a stay at the highest or lowest value that clipping explains and chance does not:
/// at least `LEAST` samples long, and either
/// entered or left by a jump of more than `JUMP` times the axis's resolution, or with `CROWD` times as many samples at the extreme as at
/// the values next to it on an axis that spans more than `SPAN` of them. A sensor at rest that reads two or three counts repeats its
/// extremes too, but spans little; a slow turn's peak is flat for a while, but the values next to it are about as frequent.
///
/// # Errors
/// As [`Samples::piece`].
pub(crate) fn extremes(samples: &dyn Samples) -> io::Result<Vec<Extremes>> {
    let all = Sensor::ALL.into_iter().flat_map(|sensor| (0..3).map(move |axis| (sensor, axis)));
    let (low, high, held, plateaus) = (f64::INFINITY, f64::NEG_INFINITY, false, Vec::new());
    let mut axes: Vec<Extremes> = all
        .map(|(sensor, axis)| Extremes { sensor, axis, low, high, held, plateaus: plateaus.clone() })
        .collect();
    let mut holds = Sensor::ALL.map(|sensor| (sensor, Hold::default()));
    samples.each(0..samples.len(), &mut |sample| {
        for axis in &mut axes {
            let v = axis.of(sample);
            (axis.low, axis.high) = (axis.low.min(v), axis.high.max(v));
        }
        holds.iter_mut().for_each(|(sensor, hold)| hold.take(sample.of(*sensor)));
    })?;
    for axis in &mut axes {
        axis.held = holds.iter().any(|(sensor, hold)| *sensor == axis.sensor && hold.is_one());
    }
    let stays =
        |axis: &Extremes, resolution: f64| [axis.low, axis.high].map(|value| Stay::new(value, resolution));
    let changing: Vec<(&mut Extremes, [Stay; 2])> = axes
        .iter_mut()
        .filter(|a| a.constant().is_none())
        .map(|a| {
            let s = stays(a, f64::INFINITY);
            (a, s)
        })
        .collect();
    // Few axes stay anywhere; only theirs need a resolution.
    let staying = watched(samples, changing)?.into_iter();
    let staying: Vec<&mut Extremes> = staying
        .filter(|(_, both)| both.iter().any(|stay| stay.any.is_some()))
        .map(|(axis, _)| axis)
        .collect();
    let resolutions = resolutions(samples, &staying)?;
    let again = staying
        .into_iter()
        .zip(resolutions)
        .map(|(a, r)| {
            let s = stays(a, r);
            (a, s)
        })
        .collect();
    for (axis, both) in watched(samples, again)? {
        let span = axis.high - axis.low;
        axis.plateaus = both.into_iter().filter_map(|stay| stay.plateau(span)).collect();
    }
    Ok(axes)
}

/// Hands every sample to the stays of its axes.
fn watched<'a>(
    samples: &dyn Samples,
    mut axes: Vec<(&'a mut Extremes, [Stay; 2])>,
) -> io::Result<Vec<(&'a mut Extremes, [Stay; 2])>> {
    if !axes.is_empty() {
        let mut before: Option<ImuSample> = None;
        samples.each(0..samples.len(), &mut |sample| {
            for (axis, both) in &mut axes {
                let v = axis.of(sample);
                let is_old = axis.held && before.is_some_and(|s| s.of(axis.sensor) == sample.of(axis.sensor));
                both.iter_mut().for_each(|stay| if is_old { stay.index += 1 } else { stay.take(v) });
            }
            before = Some(*sample);
        })?;
    }
    axes.iter_mut().flat_map(|(_, both)| both).for_each(|stay| stay.close(f64::NAN));
    Ok(axes)
}

/// Whether a sensor's values stand on several rows each, all three axes together: most of them do then.
#[derive(Debug, Default)]
struct Hold {
    last: Option<[f64; 3]>,
    /// Rows of the last value, values, and those that stand on one row alone.
    rows: usize,
    values: usize,
    alone: usize,
}

impl Hold {
    fn take(&mut self, value: [f64; 3]) {
        if self.last == Some(value) {
            self.rows += 1;
        } else {
            self.alone += usize::from(self.rows == 1);
            (self.last, self.rows, self.values) = (Some(value), 1, self.values + 1);
        }
    }

    fn is_one(&self) -> bool {
        self.values >= LEAST && 2 * self.alone < self.values
    }
}

/// Stays of one axis at one value.
#[derive(Debug)]
struct Stay {
    value: f64,
    resolution: f64,
    /// Samples at the value, and next to it.
    at: usize,
    near: usize,
    /// Of all stays long enough, and of those with a jump.
    any: Option<Plateau>,
    jumped: Option<Plateau>,
    index: usize,
    /// The last other value, and the samples that have stayed since.
    last: f64,
    stayed: usize,
}

impl Stay {
    fn new(value: f64, resolution: f64) -> Self {
        let (at, near, index, stayed) = (0, 0, 0, 0);
        Self { value, resolution, at, near, any: None, jumped: None, index, last: f64::NAN, stayed }
    }

    fn take(&mut self, v: f64) {
        if v == self.value {
            self.at += 1;
            self.stayed += 1;
        } else {
            self.near += usize::from((v - self.value).abs() < 1.5 * self.resolution);
            self.close(v);
            self.last = v;
        }
        self.index += 1;
    }

    /// Ends a stay before `after`; NaN at the end.
    fn close(&mut self, after: f64) {
        if self.stayed >= LEAST {
            let (longest, first) = (self.stayed, self.index - self.stayed);
            let note = |found: &mut Option<Plateau>| {
                let plateau = found.get_or_insert(Plateau { value: self.value, longest, first });
                plateau.longest = plateau.longest.max(longest);
            };
            note(&mut self.any);
            if [self.last, after].iter().any(|beside| (beside - self.value).abs() > JUMP * self.resolution) {
                note(&mut self.jumped);
            }
        }
        self.stayed = 0;
    }

    fn plateau(self, span: f64) -> Option<Plateau> {
        let crowded = span > SPAN * self.resolution && self.at >= CROWD * self.near;
        if crowded { self.any } else { self.jumped }
    }
}

/// The smallest difference between two values of each axis: a converter's count, or next to nothing where there is none.
fn resolutions(samples: &dyn Samples, axes: &[&mut Extremes]) -> io::Result<Vec<f64>> {
    /// The smallest distinct values above `floor`, `HELD` of them up to `most`.
    struct Lowest {
        floor: f64,
        most: f64,
        held: Vec<f64>,
        least: f64,
    }
    let sort = |lowest: &mut Lowest| {
        lowest.held.sort_unstable_by(f64::total_cmp);
        lowest.held.dedup();
        lowest.held.truncate(HELD);
        lowest.most = lowest.held.get(HELD - 1).copied().unwrap_or(f64::INFINITY);
    };
    let mut all: Vec<Lowest> = axes
        .iter()
        .map(|_| Lowest {
            floor: f64::NEG_INFINITY,
            most: f64::INFINITY,
            held: Vec::new(),
            least: f64::INFINITY,
        })
        .collect();
    // An axis without a converter's counts is gone through part by part.
    while all.iter().any(|axis| axis.floor < f64::INFINITY) {
        samples.each(0..samples.len(), &mut |sample| {
            for (axis, lowest) in axes.iter().zip(&mut all) {
                let v = axis.of(sample);
                if v > lowest.floor && v < lowest.most {
                    lowest.held.push(v);
                    if lowest.held.len() == 2 * HELD {
                        sort(lowest);
                    }
                }
            }
        })?;
        for (axis, lowest) in axes.iter().zip(&mut all) {
            sort(lowest);
            // Counts times a factor differ in their last bits; what is closer than that is one value.
            let rounding = 1e-9 * axis.low.abs().max(axis.high.abs());
            let mut before = Some(lowest.floor).filter(|floor| floor.is_finite());
            for v in &lowest.held {
                if let Some(step) = before.map(|before| v - before).filter(|step| *step > rounding) {
                    lowest.least = lowest.least.min(step);
                }
                before = Some(*v);
            }
            (lowest.floor, lowest.most) = (lowest.most, f64::INFINITY);
            lowest.held.clear();
        }
    }
    Ok(all.into_iter().map(|axis| axis.least).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::time::Stamp;

    fn plateaus(signal: &[f64]) -> Vec<Plateau> {
        let at =
            |(i, v): (usize, &f64)| ImuSample { t: Stamp::from_ns(i as i64), gyro: [*v; 3], accel: [0.0; 3] };
        let samples: Vec<ImuSample> = signal.iter().enumerate().map(at).collect();
        let found = extremes(&samples.as_slice()).unwrap();
        assert!(found[..3].iter().all(|a| a.constant() == Some(0.0) && a.plateaus.is_empty()));
        assert_eq!(found[3].plateaus, found[5].plateaus);
        found[5].plateaus.clone()
    }

    #[test]
    fn more_values_than_are_held_have_the_smallest_difference_of_them_all() {
        // The nearest two lie across the end of the first part.
        let mut values: Vec<f64> = (0..3 * HELD).map(|i| i as f64).collect();
        values[HELD] -= 0.75;
        values.reverse();
        let at = |v: &f64| ImuSample { t: Stamp::from_ns(0), gyro: [*v; 3], accel: [*v; 3] };
        let samples: Vec<ImuSample> = values.iter().map(at).collect();
        let mut axes = extremes(&samples.as_slice()).unwrap();
        let axes: Vec<&mut Extremes> = axes.iter_mut().collect();
        assert_eq!(resolutions(&samples.as_slice(), &axes).unwrap(), [0.25; 6]);
    }

    #[test]
    fn a_clipped_wave_stays_at_both_limits() {
        let wave: Vec<f64> = (0..1000).map(|i| (f64::from(i) * 0.1).sin().clamp(-0.5, 0.75)).collect();
        let found = plateaus(&wave);
        assert_eq!(found.iter().map(|p| p.value).collect::<Vec<_>>(), [-0.5, 0.75]);
        // sin > .75 from .848 to 2.294 rad: steps 9 to 22.
        assert_eq!((found[1].first, found[1].longest), (9, 15));
    }

    #[test]
    fn values_that_stand_on_seven_rows_each_are_no_clipping_and_clipped_ones_among_them_are() {
        let held = |most: f64| -> Vec<f64> {
            (0..2100)
                .map(|i| (f64::from(i / 7) * 0.3).sin().min(most) + 1e-3 * f64::from((i / 7) % 5))
                .collect()
        };
        assert_eq!(plateaus(&held(2.0)), []);
        let of = |signal: &[f64]| {
            let at = |(i, v): (usize, &f64)| ImuSample {
                t: Stamp::from_ns(i as i64),
                gyro: [*v, f64::from(i as i32 / 7), 0.5],
                accel: [0.0; 3],
            };
            let samples: Vec<ImuSample> = signal.iter().enumerate().map(at).collect();
            extremes(&samples.as_slice()).unwrap().swap_remove(3).plateaus
        };
        let clipped: Vec<f64> = (0..2100).map(|i| (f64::from(i / 7) * 0.1).sin().min(0.5)).collect();
        let found = of(&clipped);
        assert_eq!(found.iter().map(|p| p.value).collect::<Vec<_>>(), [0.5]);
        assert_eq!(of(&held(2.0)), []);
    }

    #[test]
    fn neither_three_samples_nor_two_counts_nor_a_round_top_are_clipping() {
        assert_eq!(plateaus(&[0.0, 1.0, 100.0, 100.0, 100.0, 50.0, 0.5]), []);
        assert_eq!(plateaus(&[0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0]), []);
        let round: Vec<f64> = (0..4000).map(|i| ((f64::from(i) * 0.005).sin() * 500.0).round()).collect();
        assert_eq!(plateaus(&round), []);
    }
}
