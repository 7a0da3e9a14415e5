//! `dpn noise --follow`: deviations beside a running sensor.

use super::log;
use crate::args::{HowArgs, NoiseArgs, RowFormat};
use crate::ui::{errln, refuse};
use anyhow::Result;
use dpn_core::{NoiseModel, SampleRate, Sensor, Stamp};
use dpn_io::{CsvOptions, ImuLines, axis_columns};
use dpn_probe::log_noise::{Answer, Plan};
use dpn_pronet::DualProNet;
use std::io::{self, BufRead, Read, Write};
use std::path::Path;

/// Bytes that a line may have: more is no row, and what never ends must not fill the memory.
const LONGEST_LINE: u64 = 1 << 20;

/// Samples after which the rate is held against what was said.
const ENOUGH: usize = 400;

/// The rate of the samples on stdin, as told.
pub(super) fn rate(how: &HowArgs) -> SampleRate {
    how.rate.unwrap_or(SampleRate::HZ_200)
}

/// Reads lines until stdin ends. A row that cannot be read, a stamp that does not increase and a value that is not finite are said on stderr
/// and passed over.
pub(crate) fn run(args: &NoiseArgs, plan: &Plan<'_>) -> Result<()> {
    let mut lines =
        ImuLines::new(Path::new("stdin"), CsvOptions { rate: None, ..log::options(&args.how).csv });
    let mut feed = plan.feed()?.watched(plan.noise.spec(), plan.noise.rate());
    let mut doubted = [false; 2];
    let mut before = feed.judged();
    let (mut first, mut last): (Option<Stamp>, Option<Stamp>) = (None, None);
    let mut index = 0usize;
    let (mut input, mut line) = (io::stdin().lock(), Vec::new());
    let mut out = io::stdout().lock();
    if args.format == RowFormat::Csv {
        let [accel, gyro] = [axis_columns("accel_std", "m s^-2"), axis_columns("gyro_std", "rad s^-1")];
        writeln!(out, "#timestamp [ns],{accel},{gyro}")?;
        out.flush()?;
    }
    loop {
        line.clear();
        if input.by_ref().take(LONGEST_LINE).read_until(b'\n', &mut line)? == 0 {
            return Ok(());
        }
        if line.len() as u64 == LONGEST_LINE && !line.ends_with(b"\n") {
            let text = format!("stdin: a line of more than {LONGEST_LINE} bytes");
            return refuse(text, "a sample is a line of text; bags are read by `dpn noise -`");
        }
        let samples = match lines.push(&line) {
            Ok(samples) => samples,
            // Nothing after a header without the columns can be understood.
            Err(error) if index == 0 => return Err(error.into()),
            Err(error) => {
                errln!("warning: {error}; passed over");
                continue;
            }
        };
        for sample in samples {
            if !sample.is_finite() || last.is_some_and(|last| sample.t <= last) {
                errln!(
                    "warning: a stamp of {} ns does not come after the one before; passed over",
                    sample.t.ns()
                );
                continue;
            }
            last = Some(sample.t);
            let start = *first.get_or_insert(sample.t);
            let noise = feed.feed(&sample);
            for (said, doubt) in doubted.iter_mut().zip(feed.doubts()) {
                if let Some(doubt) = doubt.filter(|_| !*said) {
                    errln!("warning: {}", doubt.words(&plan.noise.spec().to_string()));
                }
                *said = doubt.is_some();
            }
            if index == ENOUGH {
                let found = ENOUGH as f64 / sample.t.seconds_since(start);
                if (found / rate(&args.how).hz() - 1.0).abs() > DualProNet::RATE_TOLERANCE {
                    errln!(
                        "warning: the samples come at {found:.1} Hz, not at {:.1} Hz (--rate)",
                        rate(&args.how).hz()
                    );
                }
            }
            if index.is_multiple_of(plan.every()) {
                let judged = feed.judged();
                let answer = Answer { t: sample.t, noise, judged: judged.since(&before) };
                before = judged;
                let wrote = match args.format {
                    RowFormat::Jsonl => writeln!(out, "{}", json(&answer)),
                    RowFormat::Csv => {
                        let ([ax, ay, az], [gx, gy, gz]) = (noise.of(Sensor::Accel), noise.of(Sensor::Gyro));
                        writeln!(out, "{},{ax:?},{ay:?},{az:?},{gx:?},{gy:?},{gz:?}", sample.t.ns())
                    }
                };
                match wrote.and_then(|()| out.flush()) {
                    // Whoever listened has gone.
                    Err(error) if error.kind() == io::ErrorKind::BrokenPipe => return Ok(()),
                    other => other?,
                }
            }
            index += 1;
        }
    }
}

/// One answer as an object of JSON lines.
pub(super) fn json(answer: &Answer) -> serde_json::Value {
    serde_json::json!({
        "t_ns": answer.t.ns(), "accel_std": answer.noise.of(Sensor::Accel), "gyro_std": answer.noise.of(Sensor::Gyro),
        "judged": answer.judged,
    })
}
