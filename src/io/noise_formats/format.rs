//! Who writes noise figures, by name.

use dpn_core::config::{nearest, suggestion};
use dpn_core::named;
use serde::Serialize;
use std::str::FromStr;

named!(
    /// A way of writing noise figures.
    #[derive(PartialOrd, Ord, Serialize)]
    #[serde(rename_all = "lowercase")]
    pub enum Format {
        /// Kalibr's `imu.yaml`, ASL's `sensor.yaml`: densities.
        Kalibr = "kalibr",
        /// OpenVINS' `kalibr_imu_chain.yaml`: densities.
        OpenVins = "openvins",
        /// ORB-SLAM3's settings: densities.
        OrbSlam3 = "orbslam3",
        /// OKVIS' and OKVIS2's `imu_parameters`: densities.
        Okvis2 = "okvis2",
        /// Basalt's calibration: densities, one an axis.
        Basalt = "basalt",
        /// VINS-Mono's and VINS-Fusion's configuration: deviations per sample.
        Vins = "vins",
        /// The covariances of ROS's `sensor_msgs/Imu`: variances per sample.
        Ros = "ros",
        /// Plain variances per sample, as MathWorks' `factorIMUParameters`.
        Variances = "variances",
        /// Numbers with units, as a data sheet has them.
        Datasheet = "datasheet",
    }
);

/// A name that is no format.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no format `{typed}`; known are {}{}", Format::names(), suggestion(*nearest))]
pub struct UnknownFormat {
    typed: String,
    nearest: Option<Format>,
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
            name => Self::called(name),
        };
        known.ok_or_else(|| UnknownFormat {
            typed: text.to_owned(),
            nearest: nearest(&plain, Self::ALL.map(Self::name)).and_then(Self::called),
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
