//! Who writes noise figures, by name.

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
}
