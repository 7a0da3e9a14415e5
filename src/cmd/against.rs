//! `dpn noise LOG --against FILE`.

use super::log;
use crate::args::NoiseArgs;
use crate::ui::{errln, out, outln, results, warn};
use anyhow::{Context, Result};
use dpn_core::noise::Figure;
use dpn_core::{SampleRate, Sensor};
use dpn_io::{atomic_write, axis_columns, read_poses};
use dpn_probe::paste::{FigureLine, Paste};
use dpn_truth::{Against, Estimated, Found, Known, SensorAgainst, against};
use std::fmt::Write;
use std::path::Path;

/// Where the figures come from.
const FROM: &str = "against a trajectory";
/// What tells what a trajectory does not.
const ELSE: &str = "30 s at rest tell it, or the odometry (dpn run --noise self)";

pub(super) fn run(args: &NoiseArgs, path: &Path, trajectory: &Path) -> Result<()> {
    // A trajectory that cannot be read should not cost a log.
    let poses = read_poses(trajectory)?;
    let recording = log::read_part(path, args.span, &args.how)?.recording.held()?;
    let places = || format!("{} against {}", path.display(), trajectory.display());
    let found = against(&recording, &poses).with_context(places)?;
    let paste = paste(&found, recording.rate(), args.paste.walks);
    let formats = paste.written(&args.paste.paste.0);
    let all = serde_json::json!({
        "log": path, "against": trajectory, "found": found, "paste": paste, "formats": formats,
    });
    let biases = args.out.join("biases.csv");
    atomic_write(&biases, |file| {
        let sensors = |kind: &str| {
            let of = |sensor: &str, unit: &str| axis_columns(&format!("{sensor}_{kind}"), unit);
            format!("{},{}", of("accel", "m s^-2"), of("gyro", "rad s^-1"))
        };
        writeln!(file, "#timestamp [ns],{},{}", sensors("bias"), sensors("std"))?;
        for row in &found.biases {
            let numbers = row.bias.iter().chain(&row.std).flatten().map(|v| format!("{v:?}"));
            writeln!(file, "{},{}", row.t.ns(), numbers.collect::<Vec<_>>().join(","))?;
        }
        Ok(())
    })?;
    if found.clock_s != 0.0 {
        errln!(
            "warning: no pose lies within the log's time; the turns of both say that the trajectory's clock is {:+.3} s off, and what follows is without that",
            found.clock_s
        );
    }
    warn(&found.report.warnings);
    if results(args.out.join("against.json"), &all, args.json)? {
        return Ok(());
    }
    out!("{}{}", page(&found), paste.page(&args.paste.paste.0))?;
    Ok(outln!("\nbiases:   {}", biases.display())?)
}

fn paste(found: &Against, rate: SampleRate, walks: bool) -> Paste {
    let line = |figure: Figure| {
        let of = &found.sensors[usize::from(figure.sensor() == Sensor::Gyro)];
        let axes = if figure.is_walk() { [of.walk; 3] } else { of.white };
        let ends =
            |end: fn(&Found) -> f64| axes.each_ref().map(|axis| format!("{:.1e}", end(axis))).join(", ");
        if axes.iter().any(|axis| axis.known == Known::AtLeast) {
            let why = match found.follows {
                true => "the trajectory was made from this IMU and holds its noise",
                false => "no sensor that works has as much",
            };
            return FigureLine::unknown(
                figure,
                format!("at least {}: {why}; {ELSE}", ends(|of| of.density.low)),
            );
        }
        if axes.iter().any(|axis| axis.known == Known::AtMost) {
            let why = "the trajectory's own errors may be most of it";
            return FigureLine::unknown(
                figure,
                format!("at most {}: {why}; {ELSE}", ends(|of| of.density.high)),
            );
        }
        FigureLine {
            pasted: walks || !figure.is_walk(),
            ..FigureLine::known(figure, axes.map(|axis| axis.density), FROM)
        }
    };
    Paste { rate_hz: rate, lines: Figure::ALL.map(line).to_vec() }
}

/// Clock, frame, biases, scale and misalignment.
fn page(found: &Against) -> String {
    let report = &found.report;
    let mut text = format!(
        "{:.0} s against {} poses, {} used; {:.1} mm and {:.2} deg apart\n",
        found.seconds,
        report.poses,
        report.used,
        report.published_position_error_mm,
        report.published_rotation_error_deg
    );
    let (delay, clock_ms) = (report.delay_ms, 1e3 * found.clock_s);
    let at = |ms: f64| format!("{:.2}", clock_ms + ms);
    let (low, high) = (at(delay.value - 1.96 * delay.std), at(delay.value + 1.96 * delay.std));
    let _ =
        writeln!(text, "the trajectory's stamps are late by {} ms (95 %: {low} to {high})", at(delay.value));
    for sensor in &found.sensors {
        text.push_str(&of_sensor(sensor));
    }
    text
}

fn of_sensor(of: &SensorAgainst) -> String {
    let Estimated { value, std } = of.bias;
    let bias = [0, 1, 2].map(|axis| format!("{:.4} +- {:.4}", value[axis], 1.96 * std[axis])).join(", ");
    let number = |told: &Option<Estimated<f64>>, unit: f64| match told {
        Some(Estimated { value, std }) => format!("{:.2} +- {:.2}", unit * value, unit * 1.96 * std),
        None => "not told".to_owned(),
    };
    let scale = of.scale.each_ref().map(|axis| number(axis, 100.0)).join(", ");
    let axes = ["x by y", "x by z", "y by x", "y by z", "z by x", "z by y"];
    let told = of.misalignment.iter().flatten().zip(axes).filter(|(told, _)| told.is_some());
    let off: Vec<String> =
        told.map(|(told, axis)| format!("{axis} {}", number(told, 1f64.to_degrees()))).collect();
    let off = if off.is_empty() { "not told".to_owned() } else { off.join(", ") };
    let (sensor, unit) = (of.sensor, of.sensor.unit());
    format!("{sensor}: bias, mean {bias} {unit}; scale off by {scale} %; misaligned by {off} deg\n")
}
