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

use super::keyed::{Line, yaml};
use super::layout::{Layout, Yaml, keys};
use super::number::AxesText;
use dpn_core::noise::Meaning;

const YAML: Yaml = Yaml { head: "", indent: "", rate_first: false, rate_note: "" };

/// One number for all axes, without a rate.
const fn of(names: [&'static str; 4], white: Meaning, walk: Meaning) -> Layout {
    Layout {
        keys: keys(names, white, walk),
        rate: None,
        other_rates: &[],
        marks: &[],
        per_axis: false,
        walks_required: true,
        yaml: None,
    }
}

const fn densities(names: [&'static str; 4]) -> Layout {
    of(names, Meaning::Density, Meaning::WalkDensity)
}

pub(super) const KALIBR: Layout = Layout {
    rate: Some("update_rate"),
    other_rates: &["rate_hz"],
    marks: &["rate_hz", "sensor_type"],
    yaml: Some(Yaml { head: "# Kalibr imu.yaml: densities\nrostopic: /imu0\n", rate_first: true, ..YAML }),
    ..densities([
        "accelerometer_noise_density",
        "accelerometer_random_walk",
        "gyroscope_noise_density",
        "gyroscope_random_walk",
    ])
};

pub(super) const OPENVINS: Layout = Layout {
    marks: &["T_i_b", "Tw", "Ta", "Tg", "R_IMUtoGYRO", "R_IMUtoACC"],
    yaml: Some(Yaml {
        head: "%YAML:1.0\n# OpenVINS kalibr_imu_chain.yaml: densities\nimu0:\n",
        indent: "  ",
        ..YAML
    }),
    ..KALIBR
};

pub(super) const ORBSLAM3: Layout = Layout {
    rate: Some("IMU.Frequency"),
    yaml: Some(Yaml {
        head: "%YAML:1.0\n# ORB-SLAM3: densities\n",
        rate_note: "; ORB-SLAM3 multiplies by its root itself",
        ..YAML
    }),
    ..densities(["IMU.NoiseAcc", "IMU.AccWalk", "IMU.NoiseGyro", "IMU.GyroWalk"])
};

pub(super) const OKVIS2: Layout = Layout {
    other_rates: &["imu_rate"],
    yaml: Some(Yaml { head: "%YAML:1.0\n# OKVIS2: densities\nimu_parameters:\n", indent: "    ", ..YAML }),
    ..densities(["sigma_a_c", "sigma_aw_c", "sigma_g_c", "sigma_gw_c"])
};

pub(super) const BASALT: Layout = Layout {
    rate: Some("imu_update_rate"),
    per_axis: true,
    ..densities(["accel_noise_std", "accel_bias_std", "gyro_noise_std", "gyro_bias_std"])
};

pub(super) const VINS: Layout = Layout {
    yaml: Some(Yaml {
        head: "%YAML:1.0\n# VINS-Mono, VINS-Fusion: per sample{rate}; another rate needs other numbers\n",
        ..YAML
    }),
    ..of(["acc_n", "acc_w", "gyr_n", "gyr_w"], Meaning::SampleStd, Meaning::WalkRateStd)
};

pub(super) const VARIANCES: Layout = Layout {
    rate: Some("SampleRate"),
    per_axis: true,
    walks_required: false,
    yaml: Some(Yaml {
        head: "# variances per sample (MathWorks factorIMUParameters)\n",
        rate_first: true,
        ..YAML
    }),
    ..of(
        ["AccelerometerNoise", "AccelerometerBiasNoise", "GyroscopeNoise", "GyroscopeBiasNoise"],
        Meaning::SampleVariance,
        Meaning::WalkStepVariance,
    )
};

/// The text of a layout whose keys are `lines`.
pub(super) fn write(layout: &Layout, lines: &[Line], rate: Option<&str>) -> String {
    let Some(Yaml { head, indent, rate_first, rate_note }) = layout.yaml else {
        return basalt(lines, rate);
    };
    let head = head.replace("{rate}", &rate.map(|rate| format!(" at {rate} Hz")).unwrap_or_default());
    let rate = layout.rate.zip(rate);
    let rate =
        rate.map(|(key, rate)| format!("{indent}{key}: {rate}  # Hz{rate_note}\n")).unwrap_or_default();
    let keys = yaml(lines, indent);
    if rate_first { head + &rate + &keys } else { head + &keys + &rate }
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
