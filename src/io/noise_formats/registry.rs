//! What each format is made of, and by which keys a file's is known.

use super::format::Format;
use super::layout::Layout;
use super::tree::{Block, Tree};
use super::{datasheet, layouts, ros};

impl Format {
    /// The four keys, where the format is four keys.
    pub fn layout(self) -> Option<&'static Layout> {
        match self {
            Self::Kalibr => Some(&layouts::KALIBR),
            Self::OpenVins => Some(&layouts::OPENVINS),
            Self::OrbSlam3 => Some(&layouts::ORBSLAM3),
            Self::Okvis2 => Some(&layouts::OKVIS2),
            Self::Basalt => Some(&layouts::BASALT),
            Self::Vins => Some(&layouts::VINS),
            Self::Variances => Some(&layouts::VARIANCES),
            Self::Ros | Self::Datasheet => None,
        }
    }

    /// Whether its numbers are only meant together with a rate.
    pub fn needs_rate(self) -> bool {
        self == Self::Ros || self.layout().is_some_and(Layout::needs_rate)
    }

    /// The keys by which it is known.
    pub(super) fn own_keys(self) -> Vec<&'static str> {
        match (self, self.layout()) {
            (_, Some(layout)) => layout.keys.map(|key| key.name).to_vec(),
            (Self::Ros, None) => ros::KEYS.to_vec(),
            (_, None) => datasheet::KEYS.map(|(name, _)| name).to_vec(),
        }
    }

    /// The format of most of whose keys a file has; `None` where it has none of any.
    pub(super) fn of(tree: &Tree) -> Option<Self> {
        let blocks = tree.blocks();
        let score = |format: Self| {
            let keys = format.own_keys();
            let marks = format.layout().map_or(&[][..], |layout| layout.marks);
            let count = |block: &Block<'_>| {
                let own = keys.iter().filter(|key| block.get(key).is_some()).count();
                let marked = marks.iter().any(|mark| block.get(mark).is_some());
                // A mark counts less than any key.
                if own == 0 { 0 } else { 2 * own + usize::from(marked) }
            };
            blocks.iter().map(count).max().unwrap_or(0)
        };
        let best = Self::ALL.into_iter().rev().max_by_key(|format| score(*format))?;
        (score(best) > 0).then_some(best)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn a_file_is_known_by_its_keys() {
        let of = |text: &str| Format::of(&Tree::parse(text.as_bytes(), Path::new("f")).unwrap());
        assert_eq!(of("accelerometer_noise_density: 1\n"), Some(Format::Kalibr));
        assert_eq!(of("imu0:\n  accelerometer_noise_density: 1\n  T_i_b: []\n"), Some(Format::OpenVins));
        assert_eq!(of("acc_n: 1\ngyr_n: 2\n"), Some(Format::Vins));
        assert_eq!(of("{\"value0\": {\"gyro_noise_std\": 1}}"), Some(Format::Basalt));
        assert_eq!(of("imu_parameters:\n  sigma_a_c: 1\n"), Some(Format::Okvis2));
        assert_eq!(of("linear_acceleration_covariance: []\n"), Some(Format::Ros));
        assert_eq!(of("camera: 1\n"), None);
    }
}
