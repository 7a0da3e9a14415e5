//! Rate, jitter, dropped samples, samples that come twice.

use super::clock;
use super::kept::Kept;
use crate::finding::Finding;
use dpn_core::Recorded;
use dpn_core::check::is_made_up;
use dpn_core::signal::ranks::{Column, Level, levels};
use std::io;

/// Jitter of a step, relative to the median one, from which an integrator notices.
const JITTER: f64 = 0.05;
/// Rates by count and by the median step that are one.
const UNEVEN: f64 = 1.1;
/// A step longer than nearly all others by this factor is a hole, not the pause behind a burst.
const PAUSE: f64 = 5.0;
/// Share of samples equal to the one before from which the log is polled faster than the sensor,
const TWICE: f64 = 0.05;
/// and from which the rest of what is found would be found of that.
const MOSTLY: f64 = 0.4;

/// What is to be said, and how many samples were lost.
pub(super) fn findings(recording: &dyn Recorded) -> io::Result<(Vec<Finding>, f64)> {
    let period = recording.rate().period();
    let count = recording.len() - 1;
    let mut findings = Vec::new();
    let mean_hz = count as f64 / recording.length_s();
    findings.push(Finding::note(
        "rate",
        format!("{:.3} Hz by the median step, {mean_hz:.3} Hz by the mean one", recording.rate().hz()),
    ));
    findings.extend(clock::unlikely(recording.rate()));
    let each_step = |take: &mut dyn FnMut(f64)| recording.pairs(&mut |a, b| take(b.t.seconds_since(a.t)));
    let Steps { ends, longest, usual } = Steps::of(recording)?;
    let [low, high] = ends.map(|step| step / period - 1.0);
    let (by_step, by_count) = (recording.rate().hz(), usual.recip());
    let mut bursts = 0;
    each_step(&mut |step| bursts += usize::from(step <= longest && step < 0.2 * usual))?;
    let is_burst = bursts as f64 > 0.05 * count as f64;
    let period = if is_burst { usual } else { period };
    let holes = holes(recording, if is_burst { longest } else { 1.5 * period }, period)?;
    let mut made_up = String::new();
    if holes.late > 0 {
        made_up = format!(
            "; {} step(s) of up to {:.3} s are made up for by shorter ones, so that no sample is lost there",
            holes.late, holes.latest_s
        );
    }
    if holes.late > 0 || is_burst {
        let meant = count as f64 / (recording.length_s() - holes.lost * period);
        made_up.push_str(&format!("; stamps are times of arrival, {meant:.2} Hz are what they mean"));
    }
    if is_burst {
        findings.push(Finding::bad(
            "jitter",
            format!("{bursts} steps are shorter than a fifth of the mean one: samples were stamped as a queue was emptied{made_up}"),
            "stamp samples where they are taken; or count them: --rate",
        ));
    } else if high > JITTER || low < -JITTER {
        findings.push(Finding::warning(
            "jitter",
            format!(
                "1 % of the steps are shorter than {:.2} and 1 % longer than {:.2} periods{made_up}",
                1.0 + low,
                1.0 + high
            ),
            "take the sensor's own clock for stamps, not the time of arrival, or count them: --rate; an integrator turns jitter into noise",
        ));
    }
    findings.extend(holes.finding(recording.len()));
    if !is_burst && by_count > UNEVEN * by_step {
        findings.push(Finding::bad(
            "rate",
            format!("{by_step:.1} Hz by the median step, but {by_count:.1} Hz by the number of samples: coarse stamps, or samples that are lost regularly"),
            "write stamps with more digits, or count the samples: --rate; noise per sample goes with the rate",
        ));
    }
    Ok((findings, holes.lost))
}

/// Steps from sample to sample. A burst empties a queue: many steps near zero, then a long one; the median step says nothing then.
struct Steps {
    /// Where the shortest and the longest hundredth end \[s\].
    ends: [f64; 2],
    /// Longer ones are holes \[s\].
    longest: f64,
    /// Mean of the others \[s\].
    usual: f64,
}

impl Steps {
    fn of(recording: &dyn Recorded) -> io::Result<Self> {
        let each_step = |take: &mut dyn FnMut(f64)| recording.pairs(&mut |a, b| take(b.t.seconds_since(a.t)));
        let asked = [0.01, 0.99, 0.97].map(Level::Quantile);
        let column = Column { count: recording.len() - 1, levels: &asked };
        let found = levels(&[column], |take| each_step(&mut |step| take(0, step)))?;
        // Holes are no pauses behind bursts: without them, one of a minute would make every other step a short one.
        let longest = PAUSE * found[0][2];
        let (mut sum, mut even) = (0.0, 0.0);
        each_step(&mut |step| {
            if step <= longest {
                (sum, even) = (sum + step, even + 1.0);
            }
        })?;
        // The second pass recovers the digits the first lost, as in `stats::mean`.
        let (rough, mut off) = (sum / even, 0.0);
        each_step(&mut |step| off += if step <= longest { step - rough } else { 0.0 })?;
        Ok(Self { ends: [found[0][0], found[0][1]], longest, usual: rough + off / even })
    }
}

/// That the median step is much shorter than the mean one, so that what is counted per sample is at most one of two rates'.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(crate) fn batched(recording: &dyn Recorded) -> io::Result<Option<String>> {
    /// Rates from which densities are a tenth apart.
    const APART: f64 = 1.25;
    let (by_step, by_count) = (recording.rate().hz(), Steps::of(recording)?.usual.recip());
    Ok((by_step > APART * by_count).then(|| {
        format!(
            "NOT KNOWN: the rate is {by_step:.1} Hz by the median step and {by_count:.1} Hz by the number of samples: unless the others were lost, samples came in batches, \
             and densities are up to {:.2} times too small: --rate {by_count:.1} counts them",
            (by_step / by_count).sqrt()
        )
    }))
}

/// Steps that are longer than they should be.
#[derive(Debug, Default)]
struct Holes {
    /// Those in which samples were lost, and how many.
    count: usize,
    lost: f64,
    /// Where the first of them are, and the longest, from the log's begin; its length \[s\].
    places: Vec<f64>,
    at: f64,
    longest: f64,
    /// Those that shorter steps around make up for, and the longest of them \[s\].
    late: usize,
    latest_s: f64,
}

/// Looks at the steps longer than `limit` \[s\]. Jitter is no loss: rows times period against the span around a step tells.
fn holes(recording: &dyn Recorded, limit: f64, period: f64) -> io::Result<Holes> {
    /// Steps that are looked at one by one; of more the first ones tell.
    const MOST: usize = 10_000;
    let start = recording.span()[0];
    let mut steps: Vec<(usize, f64, f64)> = Vec::new();
    let (mut index, mut more) = (0, 0);
    recording.pairs(&mut |a, b| {
        let step = b.t.seconds_since(a.t);
        if step > limit && steps.len() < MOST {
            steps.push((index, a.t.seconds_since(start), step));
        } else if step > limit {
            more += 1;
        }
        index += 1;
    })?;
    let looked_at = steps.len();
    let mut holes = Holes::default();
    for (index, from, step) in steps {
        let lost = (step / period).round() - 1.0;
        if is_made_up(recording, index, step, period)? {
            holes.late += 1;
            holes.latest_s = holes.latest_s.max(step);
            continue;
        }
        holes.count += 1;
        holes.lost += lost;
        holes.places.push(from);
        if step >= holes.longest {
            (holes.at, holes.longest) = (from, step);
        }
    }
    let share = 1.0 + more as f64 / looked_at.max(1) as f64;
    holes.count = (holes.count as f64 * share).round() as usize;
    holes.late = (holes.late as f64 * share).round() as usize;
    holes.lost *= share;
    Ok(holes)
}

impl Holes {
    fn finding(&self, len: usize) -> Option<Finding> {
        /// Places that are named.
        const NAMED: usize = 5;
        let Self { count, lost, places, at, longest, .. } = self;
        if *count == 0 {
            return None;
        }
        let more = if *count > NAMED { ", ..." } else { "" };
        let places: Vec<String> = places.iter().take(NAMED).map(|at| format!("{at:.2}")).collect();
        let text = format!(
            "{count} hole(s), about {lost:.0} samples lost; at {}{more} s; the longest, {longest:.3} s, at {at:.2} s",
            places.join(", ")
        );
        let remedy = "look for a full buffer or a slow disk where the log was written; an estimator integrates across a hole with one sample";
        let is_bad = *lost > 0.001 * len as f64 || *longest > 0.1;
        Some(Finding::bad_where(is_bad, "gaps", text, remedy))
    }
}

/// A recording without the rows that are the one before once more, where most are and what follows would be of them; and what is to be said.
///
/// # Errors
/// As [`Samples::piece`](dpn_core::Samples::piece).
pub(super) fn without_repeats(recording: &dyn Recorded) -> io::Result<(Option<Kept<'_>>, Option<Finding>)> {
    /// Rows that are looked at where most repeat: their places are held.
    const ROWS: usize = 4_000_000;
    let mut twice = 0;
    recording.pairs(&mut |a, b| twice += usize::from(a.gyro == b.gyro && a.accel == b.accel))?;
    let len = recording.len();
    let share = twice as f64 / len as f64;
    if share <= TWICE {
        return Ok((None, None));
    }
    let text = format!("{:.0} % of the samples are the one before once more, all six axes", 100.0 * share);
    // A dead sensor repeats as well, and that is said of it.
    if share <= MOSTLY || len - twice < 16 {
        let remedy = "the sensor is read faster than it measures, or it was frozen; log at its own rate, for noise per sample is wrong like this";
        return Ok((None, Some(Finding::warning("repeats", text, remedy))));
    }
    let (mut out, mut index, rows) = (Vec::new(), 0, len.min(ROWS));
    recording.pairs(&mut |a, b| {
        index += 1;
        if index < rows && a.gyro == b.gyro && a.accel == b.accel {
            out.push(index);
        }
    })?;
    let hz = recording.rate().hz();
    let text = format!(
        "{text}: each stands there {:.1} times, so the sensor has {:.1} Hz, not {hz:.1}; values, vibration and rest are looked at without them",
        1.0 / (1.0 - share),
        hz * (1.0 - share)
    );
    let kept = Kept::new(recording, 0..rows, out)?;
    let remedy = "log at the sensor's own rate, or drop the rows that are the one before once more: noise per row is wrong like this";
    Ok((kept, Some(Finding::bad("repeats", text, remedy))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Weight;
    use crate::doctor::examine;
    use crate::doctor::values::tests::level;
    use dpn_core::{ImuRecording, ImuSample, Stamp};

    fn of(samples: Vec<ImuSample>) -> Vec<Finding> {
        findings(&ImuRecording::new(samples).unwrap()).unwrap().0
    }

    fn find<'a>(findings: &'a [Finding], about: &str) -> Option<&'a Finding> {
        findings.iter().find(|f| f.about == about)
    }

    #[test]
    fn a_clean_log_has_a_rate_and_nothing_else() {
        let found = of(level(30));
        assert_eq!(found.len(), 1);
        assert_eq!(found[0].text, "200.000 Hz by the median step, 200.000 Hz by the mean one");
    }

    #[test]
    fn holes_are_counted_with_their_places() {
        let mut samples = level(30);
        samples.drain(1000..1003);
        samples.drain(4000..4001);
        let found = of(samples);
        let gaps = find(&found, "gaps").unwrap();
        assert_eq!(gaps.weight, Weight::Warning);
        assert!(gaps.text.starts_with("2 hole(s), about 4 samples lost; at "), "{gaps:?}");
        assert!(gaps.text.contains(", 20.01 s; the longest, 0.020 s, at "), "{gaps:?}");
    }

    #[test]
    fn a_pause_of_a_minute_is_a_hole_and_no_jitter() {
        let mut samples = level(30);
        for s in &mut samples[3000..] {
            s.t = Stamp::from_ns(s.t.ns() + 60_000_000_000);
        }
        let found = of(samples.clone());
        assert!(find(&found, "jitter").is_none(), "{found:?}");
        let gaps = find(&found, "gaps").unwrap();
        assert!(gaps.weight == Weight::Bad && gaps.text.contains("the longest, 60.005 s, at "), "{gaps:?}");
        // Behind bursts too.
        for (i, s) in samples.iter_mut().enumerate() {
            let pause = if i < 3000 { 0 } else { 60_000_000_000 };
            s.t = Stamp::from_ns(pause + (i as i64 / 4) * 20_000_000 + (i as i64 % 4) * 100_000);
        }
        let found = of(samples);
        assert!(find(&found, "jitter").is_some());
        assert!(find(&found, "gaps").unwrap().text.starts_with("1 hole(s), "), "{found:?}");
    }

    #[test]
    fn jitter_bursts_and_repeats_are_told_apart() {
        let mut samples = level(30);
        for (i, s) in samples.iter_mut().enumerate() {
            s.t = Stamp::from_ns(s.t.ns() + if i % 7 == 0 { 1_000_000 } else { 0 });
        }
        let found = of(samples.clone());
        assert_eq!(find(&found, "jitter").map(|f| f.weight), Some(Weight::Warning));
        for (i, s) in samples.iter_mut().enumerate() {
            // Four at a time.
            s.t = Stamp::from_ns((i as i64 / 4) * 20_000_000 + (i as i64 % 4) * 100_000);
        }
        assert!(of(samples).iter().any(|f| f.weight == Weight::Bad && f.about == "jitter"));
        let mut polled = level(30);
        for i in (1..polled.len()).step_by(2) {
            (polled[i].gyro, polled[i].accel) = (polled[i - 1].gyro, polled[i - 1].accel);
        }
        let polled = ImuRecording::new(polled).unwrap();
        let (kept, found) = without_repeats(&polled).unwrap();
        let found = found.unwrap();
        assert!(found.weight == Weight::Bad && found.text.starts_with("50 % of the samples"), "{found:?}");
        assert!((kept.unwrap().rate().hz() - 100.0).abs() < 1e-9);
    }

    #[test]
    fn what_follows_from_rows_that_repeat_is_folded_under_them() {
        let sound = level(40);
        let turning = |i: usize| {
            let [x, y, z] = sound[i].gyro;
            ImuSample { gyro: [x + 0.6 * (i as f64 * 0.03).sin(), y, z], ..sound[i] }
        };
        // Every sample on seven rows.
        let held = (0..7000).map(|i| ImuSample { t: sound[i].t, ..turning(i / 7) }).collect();
        let found = examine(&ImuRecording::new(held).unwrap()).unwrap().findings;
        let warned: Vec<&str> = found.iter().filter(|f| f.warns()).map(|f| f.about).collect();
        assert_eq!(warned, ["repeats"], "{found:?}");
        assert!(
            found[0].text.contains("each stands there 7.0 times, so the sensor has 28.6 Hz, not 200.0"),
            "{found:?}"
        );
    }

    #[test]
    fn samples_that_arrive_in_bursts_are_not_lost_and_those_that_are_lost_among_them_are() {
        let mut rng = dpn_core::random::Stream::new(5).named("arrival").rng();
        let mut samples = level(30);
        // Each waits for up to 3 ms, now and then for 16, and none passes the one before.
        let mut last = 0;
        for s in &mut samples {
            let wait = if rand::Rng::random_bool(&mut rng, 0.03) {
                16_000_000
            } else {
                rand::Rng::random_range(&mut rng, 0..3_000_000)
            };
            last = (s.t.ns() + wait).max(last + 50_000);
            s.t = Stamp::from_ns(last);
        }
        let found = of(samples.clone());
        assert!(find(&found, "gaps").is_none(), "{found:?}");
        let jitter = find(&found, "jitter").unwrap();
        let meant = jitter
            .text
            .split("times of arrival, ")
            .nth(1)
            .and_then(|rest| rest.split(' ').next()?.parse::<f64>().ok());
        assert!((meant.unwrap() - 200.0).abs() < 0.1, "{jitter:?}");
        // The remedy: counted stamps.
        let counted = samples
            .iter()
            .enumerate()
            .map(|(i, s)| ImuSample { t: Stamp::from_ns(i as i64 * 5_000_000), ..*s });
        assert!(of(counted.collect()).iter().all(|f| !f.warns()));
        samples.drain(3000..3040);
        let found = of(samples);
        // The hole itself jitters too.
        let gaps = &find(&found, "gaps").unwrap().text;
        let lost = gaps
            .strip_prefix("1 hole(s), about ")
            .and_then(|rest| rest.split(' ').next()?.parse::<f64>().ok());
        assert!((lost.unwrap() - 40.0).abs() < 5.0, "{found:?}");
    }

    #[test]
    fn samples_stamped_a_millisecond_apart_as_they_came_in_batches_have_two_rates() {
        let mut samples = level(30);
        assert_eq!(batched(&ImuRecording::new(samples.clone()).unwrap()).unwrap(), None);
        for (i, s) in samples.iter_mut().enumerate() {
            s.t = Stamp::from_ns((i as i64 / 16) * 80_000_000 + (i as i64 % 16) * 1_000_000);
        }
        let words = batched(&ImuRecording::new(samples).unwrap()).unwrap().unwrap();
        assert!(words.contains("1000.0 Hz by the median step and 200."), "{words}");
        assert!(words.contains("2.2"), "{words}");
    }
}
