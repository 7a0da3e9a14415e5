//! How many windows networks have judged, and how many of them were unlike their training.

use dpn_core::Sensor;
use dpn_pronet::model::RangeCount;
use serde::Serialize;

/// Windows of one sensor, an axis each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Count {
    /// Windows judged.
    pub windows: u64,
    /// Of these, unlike every window of the training.
    pub outside: u64,
}

impl From<RangeCount> for Count {
    fn from(count: RangeCount) -> Self {
        Self { windows: count.windows, outside: count.outside }
    }
}

/// Windows of both sensors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct Judged {
    /// The accelerometer's.
    pub accel: Count,
    /// The gyroscope's.
    pub gyro: Count,
}

impl Judged {
    /// One sensor's.
    pub fn of(&self, sensor: Sensor) -> Count {
        match sensor {
            Sensor::Accel => self.accel,
            Sensor::Gyro => self.gyro,
        }
    }

    /// What came between `before` and this.
    #[must_use]
    pub fn since(&self, before: &Self) -> Self {
        let of = |now: Count, then: Count| Count {
            windows: now.windows - then.windows,
            outside: now.outside - then.outside,
        };
        Self { accel: of(self.accel, before.accel), gyro: of(self.gyro, before.gyro) }
    }

    /// Both together.
    pub(super) fn plus(&self, other: &Self) -> Self {
        let of =
            |a: Count, b: Count| Count { windows: a.windows + b.windows, outside: a.outside + b.outside };
        Self { accel: of(self.accel, other.accel), gyro: of(self.gyro, other.gyro) }
    }
}
