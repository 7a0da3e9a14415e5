//! Kalibr's result as text (`results-imucam.txt`, `results-imu.txt`): below `IMU0:` stand the figures that its `imu.yaml` gave it, in words.

/// The first line of every such file.
const FIRST: &str = "Calibration results";
/// A line's words, and the key of `imu.yaml` below each sensor's line.
const WORDS: [(&str, &str); 2] = [("Noise density:", "noise_density"), ("Random walk:", "random_walk")];

/// The figures of the first IMU as `imu.yaml` has them, each on its own line; none of any other file.
pub(crate) fn as_yaml(bytes: &[u8]) -> Option<String> {
    let text = std::str::from_utf8(bytes).ok().filter(|text| text.trim_start().starts_with(FIRST))?;
    let (mut yaml, mut inside, mut sensor) = (String::new(), false, None);
    for line in text.lines() {
        let line = line.trim();
        if line.starts_with("IMU") && line.ends_with(':') {
            inside = line == "IMU0:";
        }
        let mut said = None;
        if inside {
            match line {
                "Accelerometer:" => sensor = Some("accelerometer"),
                "Gyroscope:" => sensor = Some("gyroscope"),
                _ => {
                    let figure =
                        WORDS.iter().find_map(|(words, key)| Some((line.strip_prefix(words)?, *key)));
                    said =
                        figure.zip(sensor).map(|((number, key), sensor)| format!("{sensor}_{key}:{number}"));
                    said = said
                        .or_else(|| line.strip_prefix("Update rate:").map(|hz| format!("update_rate:{hz}")));
                }
            }
        }
        yaml.push_str(&said.unwrap_or_default());
        yaml.push('\n');
    }
    Some(yaml)
}

#[cfg(test)]
mod tests {
    use crate::noise_formats::{Format, Given, parse};
    use std::path::Path;

    #[test]
    fn a_results_text_is_read_as_the_file_that_it_was_made_from() {
        let text = "Calibration results\n===================\nNormalized Residuals\n----\nReprojection error (cam0):     mean 0.18, median 0.15, std: 0.13\n\n\
            IMU configuration\n=================\n\nIMU0:\n ----------------------------\n  Model: calibrated\n  Update rate: 200.0\n  Accelerometer:\n\
            \u{20}   Noise density: 0.01 \n    Noise density (discrete): 0.1414213562373095 \n    Random walk: 0.0002\n  Gyroscope:\n    Noise density: 0.005\n\
            \u{20}   Noise density (discrete): 0.07071067811865475 \n    Random walk: 4e-06\n  T_i_b\n    [[1. 0. 0. 0.]\n     [0. 1. 0. 0.]]\n\
            IMU1:\n  Accelerometer:\n    Noise density: 9\n";
        let results =
            parse(text.as_bytes(), Path::new("results-imucam.txt"), None, &Given::default()).unwrap();
        let yaml = "update_rate: 200.0\naccelerometer_noise_density: 0.01\naccelerometer_random_walk: 0.0002\n\
            gyroscope_noise_density: 0.005\ngyroscope_random_walk: 4e-06\n";
        let imu = parse(yaml.as_bytes(), Path::new("imu.yaml"), None, &Given::default()).unwrap();
        assert_eq!((results.format, &results.figures), (Format::Kalibr, &imu.figures));
        let bad = text.replace("0.005\n", "-1\n");
        let error =
            parse(bad.as_bytes(), Path::new("r.txt"), None, &Given::default()).unwrap_err().to_string();
        assert!(error.starts_with("r.txt:19: "), "{error}");
    }
}
