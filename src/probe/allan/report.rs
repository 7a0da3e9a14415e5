//! What an Allan plot says, as a page for people.

use super::compare::FigureCheck;
use super::log::AllanLog;
use super::model::Coefficient;
use crate::rest_noise::RestNoise;
use crate::text::{aligned, instrument, listed, three};
use dpn_core::Sensor;
use dpn_core::noise::Meaning;
use dpn_core::noise::{Axes, Figure};
use dpn_io::noise_formats::{Format, FormatError, Written, number, write};

/// Formats that are written out, ready to paste.
pub(crate) const PASTED: [Format; 5] =
    [Format::Kalibr, Format::OpenVins, Format::OrbSlam3, Format::Vins, Format::Basalt];

/// What people do with such numbers, and why.
pub const MULTIPLY: &str = "These are the noises of a sensor that lies still. Configurations that programs ship have 1 to 20 times the data \
    sheet's: vibration, temperature, mounting and wrong pixel noise are not in them.";

/// What is found, without the lines to paste.
pub fn page(log: &AllanLog) -> String {
    let mut text = head(log);
    for sensor in Sensor::ALL {
        text.push_str(&table(log, sensor));
    }
    text.push_str(&between(log));
    text.push_str(&lacking(log));
    text.push_str(&humps(log));
    text
}

/// The lines to paste, with what they are to be multiplied by.
///
/// # Errors
/// Those of writing a configuration.
pub fn lines_to_paste(log: &AllanLog) -> Result<String, FormatError> {
    let mut text = format!("\n{MULTIPLY}\n");
    for written in pasted(log)? {
        text.push_str(&format!("\n--- {} ---\n{}", written.format, written.text));
        for remark in written.remarks {
            text.push_str(&format!("# {remark}\n"));
        }
    }
    Ok(text)
}

/// The log's figures in every format that is written out; what is not seen is an upper bound and says so.
///
/// # Errors
/// Those of writing a configuration.
pub fn pasted(log: &AllanLog) -> Result<Vec<Written>, FormatError> {
    let figures = log.figures();
    let note = |figure: Figure| {
        let coefficient = if figure.is_walk() { Coefficient::Walk } else { Coefficient::White };
        let known = log.seen(figure.sensor(), coefficient)
            || !figure.is_walk() && log.behind(figure.sensor()).is_some();
        (!known).then(|| "not seen in this log: an upper bound".to_owned())
    };
    PASTED.into_iter().map(|format| write(&figures, format, note)).collect()
}

/// All of it for programs, with what a configuration that was held against it is told.
///
/// # Errors
/// Those of writing a configuration.
pub fn json(log: &AllanLog, check: Option<&[FigureCheck]>) -> Result<serde_json::Value, FormatError> {
    let pasted = pasted(log)?;
    let mut all =
        serde_json::json!({ "log": log, "figures": log.figures(), "formats": pasted, "advice": MULTIPLY });
    if let Some(check) = check {
        all["check"] = serde_json::json!(check);
    }
    Ok(all)
}

fn head(log: &AllanLog) -> String {
    let mut text = format!(
        "{} samples at {} Hz, {} at rest\n",
        log.samples,
        number((log.rate.hz() * 1e3).round() / 1e3),
        duration(log.length_s)
    );
    let rest = &log.rest;
    if log.bridged > 0 {
        text.push_str(&format!(
            "{} single lost sample(s) of the log bridged by straight lines\n",
            log.bridged
        ));
    }
    if !rest.moved.is_empty() {
        let spans: Vec<String> =
            rest.moved.iter().map(|s| format!("{:.0}-{:.0}", s.from_s, s.to_s)).collect();
        text.push_str(&format!(
            "not at rest throughout: {:.0} s moved (s {}); {}\n",
            rest.moved_s,
            listed(&spans),
            if log.everything {
                "used all the same, as asked".to_owned()
            } else {
                format!(
                    "used is the longest rest, {:.0} to {:.0} s",
                    rest.longest_span.from_s, rest.longest_span.to_s
                )
            }
        ));
    } else if rest.gaps > 0 && !log.everything {
        text.push_str(&format!(
            "{} hole(s) in the log; used is the longest part without, {:.0} to {:.0} s\n",
            rest.gaps, rest.longest_span.from_s, rest.longest_span.to_s
        ));
    }
    text
}

fn table(log: &AllanLog, sensor: Sensor) -> String {
    let mut rows = vec![[instrument(sensor), "x", "y", "z", ""].map(str::to_owned)];
    for coefficient in Coefficient::ALL {
        let [x, y, z] = log.estimates(sensor, coefficient).map(|e| {
            if e.seen {
                format!("{} [{}, {}]", three(e.value), three(e.low), three(e.high))
            } else {
                format!("< {}", three(e.high))
            }
        });
        let label = format!("  {} {coefficient}", coefficient.letter());
        rows.push([label, x, y, z, coefficient.unit(sensor).to_owned()]);
    }
    if let Some(densities) = log.behind(sensor) {
        let [x, y, z] =
            densities.map(|d| format!("{} [{}, {}]", three(d.value), three(d.low), three(d.high)));
        rows.push(["    N by the spectrum".to_owned(), x, y, z, Coefficient::White.unit(sensor).to_owned()]);
    }
    let per_sample = log.figures().get(Figure::white(sensor), Meaning::SampleStd, log.rate);
    let [x, y, z] = per_sample.map(Axes::each).expect("a fitted log has all figures").map(three);
    rows.push(["    N per sample".to_owned(), x, y, z, sensor.unit().to_owned()]);
    let mut misfits = log.axes.iter().filter(|a| a.sensor == sensor).map(|a| format!("{:.1}", a.fit.misfit));
    let [x, y, z] =
        std::array::from_fn(|_| misfits.next().expect("a log is fitted on three axes of either sensor"));
    rows.push(["    misfit (1: as the model)".to_owned(), x, y, z, String::new()]);
    format!("\n{}", aligned(&rows))
}

/// What stands between the noise and the log, by the spectrum.
fn between(log: &AllanLog) -> String {
    let notes: Vec<String> = log.spectrum.iter().flat_map(RestNoise::between).collect();
    if notes.is_empty() {
        return String::new();
    }
    let used = "averages over a time that these reach are not the noise's: below, N is the spectrum's";
    format!("\n{}\n{used}\n", notes.join("\n"))
}

/// What the log is too short for, and how long one would have to be.
fn lacking(log: &AllanLog) -> String {
    let mut text = String::new();
    for sensor in Sensor::ALL {
        for coefficient in Coefficient::ALL {
            let unseen: Vec<_> = log
                .axes
                .iter()
                .filter(|a| a.sensor == sensor && !a.fit.of(coefficient).seen)
                .map(|a| (a.axis, a.fit.of(coefficient)))
                .collect();
            if unseen.is_empty() {
                continue;
            }
            let axes: Vec<&str> = unseen.iter().map(|(axis, _)| *axis).collect();
            let needs: Vec<Option<f64>> = unseen.iter().map(|(_, e)| e.needs_s).collect();
            let longest = needs.iter().flatten().copied().fold(0.0, f64::max);
            let words = if needs.iter().any(Option::is_none) {
                format!("a log a hundred times as long ({}) would not do", duration(100.0 * log.length_s))
            } else {
                format!(
                    "a log of {} would show one {}",
                    duration(longest),
                    if unseen.iter().all(|(_, e)| e.value > 0.0) {
                        "as large as the fit's"
                    } else {
                        "a third of the bound"
                    }
                )
            };
            text.push_str(&format!(
                "{sensor} {}: {coefficient} not seen in {}; {words}\n",
                axes.join(" "),
                duration(log.length_s)
            ));
        }
    }
    if text.is_empty() { text } else { format!("\n{text}") }
}

/// What is no noise: something that swings.
fn humps(log: &AllanLog) -> String {
    let mut text = String::new();
    for axis in &log.axes {
        for hump in &axis.fit.humps {
            text.push_str(&format!(
                "{} {}: the plot has a hump at {:.2} s, {:.1} times the fit: something swings {}; it is left out of the fit\n",
                axis.sensor, axis.axis, hump.tau, hump.times, swing(hump.hz)
            ));
        }
    }
    text
}

/// `at about 18.6 Hz`, `about every 640 s`.
fn swing(hz: f64) -> String {
    if hz >= 0.1 { format!("at about {hz:.1} Hz") } else { format!("about every {:.0} s", 1.0 / hz) }
}

/// `45 s`, `12 min`, `2.8 h`.
fn duration(seconds: f64) -> String {
    match seconds {
        s if s < 120.0 => format!("{s:.0} s"),
        s if s < 7200.0 => format!("{:.0} min", s / 60.0),
        s if s < 172_800.0 => format!("{:.1} h", s / 3600.0),
        s => format!("{:.0} days", s / 86_400.0),
    }
}
