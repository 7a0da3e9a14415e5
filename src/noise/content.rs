//! What a spec's noise is a function of, besides the recording: by content, whatever the path.

use super::CausalError;
use super::NoiseError;
use dpn_core::Sensor;
use dpn_core::checksum::of_parts;
use dpn_core::estimate::NoiseSpec;
use dpn_io::IoError;
use dpn_pronet::network::{Network, select, variants};

/// The spec with a checksum in place of every file: of weights, of noise tracks. Two that agree in it tell the same noise of the same
/// recording; those that [need the training sequences](NoiseSpec::needs_training), where these agree too.
///
/// # Errors
/// Networks that are not there; a file that cannot be read.
pub fn content(spec: &NoiseSpec, networks: &[Network]) -> Result<String, NoiseError> {
    Ok(match spec {
        NoiseSpec::Sensors(_) | NoiseSpec::Oracle => spec.to_string(),
        NoiseSpec::DualProNet { accel, gyro } => {
            // Which of them is asked is the recording's business: those of every rate.
            let of = |sensor: Sensor, tag: &String| {
                let bytes: Result<Vec<_>, _> =
                    variants(networks, sensor, tag).map(|network| network.weights.to_bytes()).collect();
                let bytes = bytes?;
                if bytes.is_empty()
                    && let Err(source) = select(networks, sensor, tag)
                {
                    return Err(CausalError::NoNetwork { spec: spec.to_string(), source }.into());
                }
                Ok::<_, NoiseError>(of_parts(bytes))
            };
            format!("dualpronet({},{})", of(Sensor::Accel, accel)?, of(Sensor::Gyro, gyro)?)
        }
        NoiseSpec::File(path) => {
            let bytes = std::fs::read(path).map_err(|source| match source.kind() {
                std::io::ErrorKind::NotFound => IoError::Missing { path: path.clone() },
                _ => IoError::Read { path: path.clone(), source },
            })?;
            format!("file({})", of_parts([bytes]))
        }
        NoiseSpec::Shuffled(of) => format!("shuffled({})", content(of, networks)?),
        NoiseSpec::Mean(of) => format!("mean({})", content(of, networks)?),
        NoiseSpec::MeanOfTrain(of) => format!("mean-of-train({})", content(of, networks)?),
        NoiseSpec::Learned(of) => format!("self({})", content(of, networks)?),
        NoiseSpec::Plus { of, constant } => format!("plus({},{constant})", content(of, networks)?),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_file_is_known_by_what_it_holds_and_not_by_where_it_lies() {
        let dir = tempfile::tempdir().unwrap();
        let of = |name: &str, text: &str| {
            let path = dir.path().join(name);
            std::fs::write(&path, text).unwrap();
            let of = |spec: String| content(&spec.parse().unwrap(), &[]).unwrap();
            [of(format!("file(\"{}\")", path.display())), of(format!("mean(file(\"{}\"))", path.display()))]
        };
        let first = of("a.csv", "1");
        assert_eq!(first, of("b.csv", "1"));
        assert_ne!(first, of("a.csv", "2"));
        assert!(first[1] == format!("mean({})", first[0]));
        let error = content(&"shuffled(file(\"none.csv\"))".parse().unwrap(), &[]).unwrap_err().to_string();
        assert!(error.contains("none.csv does not exist"), "{error}");
    }

    #[test]
    fn specs_of_other_noises_differ() {
        let specs = [
            "x1",
            "x4,x1",
            "shuffled(x4)",
            "mean(x4)",
            "mean-of-train(x4)",
            "plus(diff2,x4)",
            "oracle",
            "self",
        ];
        let contents: std::collections::BTreeSet<String> =
            specs.iter().map(|spec| content(&spec.parse().unwrap(), &[]).unwrap()).collect();
        assert_eq!(contents.len(), specs.len());
    }
}
