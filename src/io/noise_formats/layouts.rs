//! The formats that are four keys of numbers, a table; [`write()`] makes their text.
//!
//! * Kalibr's `imu.yaml`, which ASL's and EuRoC's `sensor.yaml` and Maplab share: densities, a flat list of keys.
//! * OpenVINS' `kalibr_imu_chain.yaml`: Kalibr's keys below `imu0`, in OpenCV's YAML.
//! * ORB-SLAM3's settings: densities, which it brings to the rate `IMU.Frequency` by itself.
//! * OKVIS' and OKVIS2's `imu_parameters`: densities. `sigma_bg` and `sigma_ba` beside them are priors of the biases, no walks.
//! * Basalt's calibration (JSON, all below `value0`): densities despite the name `_std`; older files have one number for the three axes. `accel_bias_std`,
//!   `gyro_bias_std` are the walks; Basalt brings the noise to the rate `imu_update_rate` by itself.
//! * VINS-Mono's and VINS-Fusion's configuration: deviations per sample ([`vins`](super::vins)).
//! * Variances per sample, under the names of MathWorks' `factorIMUParameters` (which takes no deviations). Its page gives the unit of the bias noises,
//!   `(rad/s)^2` and `(m/s^2)^2`, and no more; here they are the variances of the bias's increment from one sample to the next.

use super::keyed::{AxesText, Line, yaml};
use super::layout::{Layout, RatePlace, Text, keys};
use dpn_core::noise::Meaning;

const DENSITIES: Layout = Layout {
    keys: keys(
        [
            "accelerometer_noise_density",
            "accelerometer_random_walk",
            "gyroscope_noise_density",
            "gyroscope_random_walk",
        ],
        Meaning::Density,
        Meaning::WalkDensity,
    ),
    rate: None,
    other_rates: &[],
    marks: &[],
    per_axis: false,
    walks_required: true,
    text: Text::Basalt,
};

pub(super) const KALIBR: Layout = Layout {
    rate: Some("update_rate"),
    other_rates: &["rate_hz"],
    marks: &["rate_hz", "sensor_type"],
    text: Text::Yaml {
        head: "# Kalibr imu.yaml: densities\nrostopic: /imu0\n",
        indent: "",
        rate: RatePlace::First,
        rate_note: "",
    },
    ..DENSITIES
};

pub(super) const OPENVINS: Layout = Layout {
    marks: &["T_i_b", "Tw", "Ta", "Tg", "R_IMUtoGYRO", "R_IMUtoACC"],
    text: Text::Yaml {
        head: "%YAML:1.0\n# OpenVINS kalibr_imu_chain.yaml: densities\nimu0:\n",
        indent: "  ",
        rate: RatePlace::Last,
        rate_note: "",
    },
    ..KALIBR
};

pub(super) const ORBSLAM3: Layout = Layout {
    keys: keys(
        ["IMU.NoiseAcc", "IMU.AccWalk", "IMU.NoiseGyro", "IMU.GyroWalk"],
        Meaning::Density,
        Meaning::WalkDensity,
    ),
    rate: Some("IMU.Frequency"),
    text: Text::Yaml {
        head: "%YAML:1.0\n# ORB-SLAM3: densities\n",
        indent: "",
        rate: RatePlace::Last,
        rate_note: "; ORB-SLAM3 multiplies by its root itself",
    },
    ..DENSITIES
};

pub(super) const OKVIS2: Layout = Layout {
    keys: keys(
        ["sigma_a_c", "sigma_aw_c", "sigma_g_c", "sigma_gw_c"],
        Meaning::Density,
        Meaning::WalkDensity,
    ),
    other_rates: &["imu_rate"],
    text: Text::Yaml {
        head: "%YAML:1.0\n# OKVIS2: densities\nimu_parameters:\n",
        indent: "    ",
        rate: RatePlace::Last,
        rate_note: "",
    },
    ..DENSITIES
};

pub(super) const BASALT: Layout = Layout {
    keys: keys(
        ["accel_noise_std", "accel_bias_std", "gyro_noise_std", "gyro_bias_std"],
        Meaning::Density,
        Meaning::WalkDensity,
    ),
    rate: Some("imu_update_rate"),
    per_axis: true,
    ..DENSITIES
};

pub(super) const VINS: Layout = Layout {
    keys: keys(["acc_n", "acc_w", "gyr_n", "gyr_w"], Meaning::SampleStd, Meaning::WalkRateStd),
    text: Text::Yaml {
        head: "%YAML:1.0\n# VINS-Mono, VINS-Fusion: per sample{rate}; another rate needs other numbers\n",
        indent: "",
        rate: RatePlace::Last,
        rate_note: "",
    },
    ..DENSITIES
};

pub(super) const VARIANCES: Layout = Layout {
    keys: keys(
        ["AccelerometerNoise", "AccelerometerBiasNoise", "GyroscopeNoise", "GyroscopeBiasNoise"],
        Meaning::SampleVariance,
        Meaning::WalkStepVariance,
    ),
    rate: Some("SampleRate"),
    per_axis: true,
    walks_required: false,
    text: Text::Yaml {
        head: "# variances per sample (MathWorks factorIMUParameters)\n",
        indent: "",
        rate: RatePlace::First,
        rate_note: "",
    },
    ..DENSITIES
};

/// The text of a layout whose keys are `lines`.
pub(super) fn write(layout: &Layout, lines: &[Line], rate: Option<&str>) -> String {
    let Text::Yaml { head, indent, rate: place, rate_note } = layout.text else {
        return basalt(lines, rate);
    };
    let head = head.replace("{rate}", &rate.map(|rate| format!(" at {rate} Hz")).unwrap_or_default());
    let rate = layout.rate.zip(rate);
    let rate =
        rate.map(|(key, rate)| format!("{indent}{key}: {rate}  # Hz{rate_note}\n")).unwrap_or_default();
    let keys = yaml(lines, indent);
    match place {
        RatePlace::First => head + &rate + &keys,
        RatePlace::Last => head + &keys + &rate,
    }
}

/// JSON has no comments: what is not known is left out.
fn basalt(lines: &[Line], rate: Option<&str>) -> String {
    let mut entries: Vec<String> =
        rate.map(|rate| format!("        \"imu_update_rate\": {rate}")).into_iter().collect();
    entries.extend(lines.iter().filter_map(|line| {
        let values = line.values?.each_text();
        Some(format!("        \"{}\": [{}]", line.key.name, values.join(", ")))
    }));
    format!("{{\n    \"value0\": {{\n{}\n    }}\n}}\n", entries.join(",\n"))
}
