//! `dpn export`.

use super::shipped;
use crate::args::{ExportWhat, OnnxArgs};
use crate::ui::outln;
use anyhow::Result;
use dpn_core::Sensor;
use dpn_io::write_file;
use dpn_pronet::network::{Network, select};
use serde_json::json;
use std::path::Path;

pub(crate) fn run(ExportWhat::Onnx(args): &ExportWhat) -> Result<()> {
    if let Some(path) = &args.inertial {
        return correction(path, args);
    }
    let networks = shipped::or_of(args.models.as_deref())?;
    for network in wanted(&networks, &args.networks)? {
        let (weights, sensor, tag) = (&network.weights, network.sensor(), network.tag());
        let bytes = dpn_onnx::to_bytes(weights)?;
        let file = args.out.join(sensor.to_string()).join(format!("{tag}.onnx"));
        write_file(&file, &bytes)?;
        let (window, rate_hz, unit) = (weights.config().window, weights.card().rate.hz(), sensor.unit());
        if args.json {
            outln!(
                "{}",
                json!({
                    "file": file, "sensor": sensor, "network": tag, "window": window, "rate_hz": rate_hz, "unit": unit,
                })
            )?;
        } else {
            outln!(
                "{}: {window} samples at {rate_hz} Hz in {unit}, {} kB",
                file.display(),
                bytes.len() / 1000
            )?;
        }
    }
    Ok(())
}

/// A learned correction of a gyroscope.
fn correction(path: &Path, args: &OnnxArgs) -> Result<()> {
    let model = dpn_inertial::Model::load(path)?;
    let (config, bytes) = (&model.card.config, model.to_onnx());
    let tag = format!("{}-s{}", config.name, config.seed);
    let file = args.out.join("inertial").join(format!("{tag}.onnx"));
    write_file(&file, &bytes)?;
    let (rate_hz, average_s) = (model.card.rate.hz(), config.average_s);
    if args.json {
        return Ok(outln!(
            "{}",
            json!({ "file": file, "sensor": Sensor::Gyro, "network": tag, "rate_hz": rate_hz, "average_s": average_s, "usage": model.card.usage })
        )?);
    }
    let (name, kb) = (file.display(), bytes.len() / 1000);
    Ok(outln!("{name}: a gyroscope's bias at {rate_hz:.0} Hz, to be averaged over {average_s} s, {kb} kB")?)
}

/// The networks of these names, of both sensors where both have one; all without names.
fn wanted<'a>(networks: &'a [Network], names: &[String]) -> Result<Vec<&'a Network>> {
    if names.is_empty() {
        return Ok(networks.iter().collect());
    }
    let mut found = Vec::new();
    for name in names {
        let of_name = Sensor::ALL.map(|sensor| select(networks, sensor, name));
        if let [Err(error), Err(_)] = of_name {
            return Err(error.into());
        }
        found.extend(of_name.into_iter().flatten());
    }
    Ok(found)
}
