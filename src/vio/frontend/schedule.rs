//! Which images are handed over.

use dpn_core::Stamp;

/// Picks the images nearest to an even rhythm, whatever the images' own.
#[derive(Debug, Clone)]
pub(super) struct Schedule {
    period: f64,
    due: Option<Stamp>,
}

impl Schedule {
    /// `rate_hz` images a second.
    pub(super) fn new(rate_hz: f64) -> Self {
        Self { period: 1.0 / rate_hz, due: None }
    }

    /// Whether the image at `t`, `since_last` seconds after the one before it, is to be handed over.
    ///
    /// The one whose time is nearest to the due one is: an image up to half an image's interval early is not beaten by the next.
    pub(super) fn is_due(&self, t: Stamp, since_last: f64) -> bool {
        // A microsecond for stamps that were rounded.
        self.due.is_none_or(|due| due.seconds_since(t) <= 0.5 * since_last.min(self.period) + 1e-6)
    }

    /// Notes that the image at `t` was handed over.
    pub(super) fn handed_over(&mut self, t: Stamp) {
        let next = self.due.unwrap_or(t).plus_seconds(self.period);
        // After a gap the rhythm begins anew.
        self.due = Some(if next.seconds_since(t) > 0.0 { next } else { t.plus_seconds(self.period) });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn handed(rate_hz: f64, stamps_ms: &[i64]) -> Vec<i64> {
        let mut schedule = Schedule::new(rate_hz);
        let mut last = None;
        let due = |t: &i64| {
            let stamp = Stamp::from_ns(t * 1_000_000);
            let since = last.map_or(0.0, |last| stamp.seconds_since(last));
            last = Some(stamp);
            let due = schedule.is_due(stamp, since);
            if due {
                schedule.handed_over(stamp);
            }
            due
        };
        let mut due = due;
        stamps_ms.iter().copied().filter(|t| due(t)).collect()
    }

    #[test]
    fn every_second_of_twenty_and_the_nearest_of_twenty_five() {
        let twenty: Vec<i64> = (0..40).map(|i| 50 * i).collect();
        assert_eq!(handed(10.0, &twenty), (0..20).map(|i| 100 * i).collect::<Vec<_>>());
        let twenty_five: Vec<i64> = (0..25).map(|i| 40 * i).collect();
        let ten = handed(10.0, &twenty_five);
        assert_eq!(ten.len(), 10);
        assert!(ten.iter().enumerate().all(|(i, t)| (t - 100 * i as i64).abs() <= 20), "{ten:?}");
        assert_eq!(handed(50.0, &twenty), twenty, "more than there are");
    }

    #[test]
    fn after_a_gap_the_rhythm_begins_anew() {
        let stamps = [0, 50, 100, 150, 200, 1030, 1080, 1130, 1180, 1230];
        assert_eq!(handed(10.0, &stamps), [0, 100, 200, 1030, 1130, 1230]);
    }
}
