//! Who writes noise figures, by name.

use super::layout::Layout;
use super::tree::Tree;
use super::{basalt, datasheet, kalibr, okvis2, openvins, orbslam3, ros, variances, vins};
use dpn_core::config::{nearest, suggestion};
use serde::Serialize;
use std::fmt;
use std::str::FromStr;

/// A way of writing noise figures.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Format {
    /// Kalibr's `imu.yaml`, ASL's `sensor.yaml`: densities.
    Kalibr,
    /// OpenVINS' `kalibr_imu_chain.yaml`: densities.
    OpenVins,
    /// ORB-SLAM3's settings: densities.
    OrbSlam3,
    /// OKVIS' and OKVIS2's `imu_parameters`: densities.
    Okvis2,
    /// Basalt's calibration: densities, one an axis.
    Basalt,
    /// VINS-Mono's and VINS-Fusion's configuration: deviations per sample.
    Vins,
    /// The covariances of ROS's `sensor_msgs/Imu`: variances per sample.
    Ros,
    /// Plain variances per sample, as MathWorks' `factorIMUParameters`.
    Variances,
    /// Numbers with units, as a data sheet has them.
    Datasheet,
}

/// A name that is no format.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no format `{typed}`; known are {}{}", Format::names(), suggestion(*nearest))]
pub struct UnknownFormat {
    typed: String,
    nearest: Option<Format>,
}

impl Format {
    /// All of them.
    pub const ALL: [Self; 9] = [
        Self::Kalibr,
        Self::OpenVins,
        Self::OrbSlam3,
        Self::Okvis2,
        Self::Basalt,
        Self::Vins,
        Self::Ros,
        Self::Variances,
        Self::Datasheet,
    ];

    /// As typed: `kalibr`, `openvins` and so on.
    pub fn name(self) -> &'static str {
        match self {
            Self::Kalibr => "kalibr",
            Self::OpenVins => "openvins",
            Self::OrbSlam3 => "orbslam3",
            Self::Okvis2 => "okvis2",
            Self::Basalt => "basalt",
            Self::Vins => "vins",
            Self::Ros => "ros",
            Self::Variances => "variances",
            Self::Datasheet => "datasheet",
        }
    }

    /// All names, for messages.
    pub fn names() -> String {
        Self::ALL.map(Self::name).join(", ")
    }

    /// The four keys, where the format is four keys.
    pub fn layout(self) -> Option<&'static Layout> {
        match self {
            Self::Kalibr => Some(&kalibr::LAYOUT),
            Self::OpenVins => Some(&openvins::LAYOUT),
            Self::OrbSlam3 => Some(&orbslam3::LAYOUT),
            Self::Okvis2 => Some(&okvis2::LAYOUT),
            Self::Basalt => Some(&basalt::LAYOUT),
            Self::Vins => Some(&vins::LAYOUT),
            Self::Variances => Some(&variances::LAYOUT),
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
            let count = |block: &super::tree::Block<'_>| {
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

impl fmt::Display for Format {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Format {
    type Err = UnknownFormat;

    fn from_str(text: &str) -> Result<Self, UnknownFormat> {
        let plain: String =
            text.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_lowercase();
        let known = match plain.as_str() {
            "asl" | "euroc" | "maplab" => Some(Self::Kalibr),
            "vinsmono" | "vinsfusion" => Some(Self::Vins),
            "okvis" => Some(Self::Okvis2),
            "orbslam" => Some(Self::OrbSlam3),
            "rosmessage" | "covariance" => Some(Self::Ros),
            "matlab" | "variance" => Some(Self::Variances),
            name => Self::ALL.into_iter().find(|format| format.name() == name),
        };
        known.ok_or_else(|| UnknownFormat {
            typed: text.to_owned(),
            nearest: nearest(&plain, Self::ALL.map(Self::name))
                .and_then(|name| Self::ALL.into_iter().find(|format| format.name() == name)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn names_and_their_usual_variants_are_known_and_slips_are_told() {
        for format in Format::ALL {
            assert_eq!(format.name().parse(), Ok(format));
        }
        assert_eq!("ORB-SLAM3".parse(), Ok(Format::OrbSlam3));
        assert_eq!("VINS-Mono".parse(), Ok(Format::Vins));
        let error = "kalbir".parse::<Format>().unwrap_err().to_string();
        assert!(
            error.starts_with("there is no format `kalbir`") && error.ends_with("(did you mean `kalibr`?)"),
            "{error}"
        );
    }

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
