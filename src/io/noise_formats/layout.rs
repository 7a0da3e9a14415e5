//! A format that is four keys of numbers: which key is what.

use dpn_core::noise::Figure;
use dpn_core::noise::Meaning;

/// One key of a configuration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    /// As written in the file.
    pub name: &'static str,
    /// Which figure it gives.
    pub figure: Figure,
    /// What its number means.
    pub meaning: Meaning,
}

/// A format that is four keys of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layout {
    /// The keys, in the order in which they are written.
    pub keys: [Key; 4],
    /// The key of the IMU's rate \[Hz\], where the format has one.
    pub rate: Option<&'static str>,
    /// Other spellings of that key.
    pub other_rates: &'static [&'static str],
    /// Keys of the file that tell this format from another with the same four.
    pub marks: &'static [&'static str],
    /// Whether the format has a value an axis; otherwise the largest of the three is written.
    pub per_axis: bool,
    /// Whether the bias walks must be there.
    pub walks_required: bool,
    /// What stands around the keys in YAML; `None` of Basalt's JSON.
    pub(super) yaml: Option<Yaml>,
}

/// What stands around the keys in YAML.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Yaml {
    /// The lines before, in which `{rate}` stands for " at N Hz".
    pub(super) head: &'static str,
    /// Before each key.
    pub(super) indent: &'static str,
    /// Whether the line of the rate comes before the keys.
    pub(super) rate_first: bool,
    /// What is said behind the rate.
    pub(super) rate_note: &'static str,
}

impl Layout {
    /// The key that gives `figure`.
    pub fn key(&self, figure: Figure) -> Key {
        self.keys.into_iter().find(|key| key.figure == figure).expect("a layout has a key for each figure")
    }

    /// Whether any of its numbers is only meant together with a rate.
    pub fn needs_rate(&self) -> bool {
        self.keys.iter().any(|key| key.meaning.needs_rate())
    }
}

/// Four keys in the order of [`Figure::ALL`]: accelerometer noise and walk, gyroscope noise and walk.
pub(super) const fn keys(names: [&'static str; 4], white: Meaning, walk: Meaning) -> [Key; 4] {
    let [accel, accel_walk, gyro, gyro_walk] = names;
    [
        Key { name: accel, figure: Figure::AccelWhite, meaning: white },
        Key { name: accel_walk, figure: Figure::AccelWalk, meaning: walk },
        Key { name: gyro, figure: Figure::GyroWhite, meaning: white },
        Key { name: gyro_walk, figure: Figure::GyroWalk, meaning: walk },
    ]
}
