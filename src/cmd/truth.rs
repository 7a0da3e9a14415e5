//! `dpn truth`.

use super::along::no_ground_truth;
use super::program;
use crate::args::TruthArgs;
use crate::ui::{errln, outln, warn};
use anyhow::{Context, Result};
use dpn_io::asl::{Sequence, discover, write_ground_truth};
use dpn_io::{ResultPath, write_file};
use dpn_truth::{Report, TruthConfig, reconcile};

pub(crate) fn run(args: &TruthArgs) -> Result<()> {
    let mut config: TruthConfig = dpn_io::config::load_over(args.config.as_deref(), &[])?;
    config.hold_out = args.hold_out.unwrap_or(config.hold_out);
    // All are looked at before the first is worked on for a minute.
    let sequences = discover(&args.source)?;
    if let Some(without) = sequences.iter().find(|s| s.ground_truth_path().is_none()) {
        return Err(no_ground_truth(without.dir(), "it is what is reconciled").into());
    }
    for sequence in &sequences {
        let json = one(sequence, &config, &args.out, &mut |line| match args.json {
            true => Ok(()),
            false => Ok(outln!("{line}")?),
        })
        .with_context(|| sequence.dir().display().to_string())?;
        if args.json {
            outln!("{json}")?;
        }
    }
    Ok(())
}

/// Reconciles those of `sequences` that `out` does not have yet from this program, a minute each.
pub(super) fn reconciled(sequences: &[Sequence], out: &ResultPath) -> Result<()> {
    let report = |name: &str| {
        let bytes = out.join(format!("{name}.json")).read().ok()??;
        serde_json::from_slice::<serde_json::Value>(&bytes).ok()
    };
    let is_made = |name: &str| {
        out.join(format!("{name}.csv")).is_file()
            && report(name).is_some_and(|said| said["program"] == program())
    };
    let missing = |sequence: &&Sequence| !is_made(sequence.name());
    for sequence in sequences.iter().filter(missing) {
        errln!("reconciling the ground truth of {}", sequence.name());
        one(sequence, &TruthConfig::default(), out, &mut |line| {
            errln!("{line}");
            Ok(())
        })
        .with_context(|| sequence.dir().display().to_string())?;
    }
    Ok(())
}

/// Writes the reconciled ground truth of a sequence and its report, says a line of it, and returns the report.
fn one(
    sequence: &Sequence,
    config: &TruthConfig,
    out: &ResultPath,
    say: &mut dyn FnMut(&str) -> Result<()>,
) -> Result<serde_json::Value> {
    let done = reconcile(&sequence.imu()?, &sequence.ground_truth()?, config)?;
    let name = sequence.name();
    let json = serde_json::json!({
        "program": program(), "sequence": name, "config": config, "report": done.report,
    });
    let text = serde_json::to_string_pretty(&json)? + "\n";
    write_file(out.join(format!("{name}.json")), &text)?;
    // Last: where it lies, its report does too.
    let file = out.join(format!("{name}.csv"));
    write_ground_truth(&file, &done.truth)?;
    warn(done.report.warnings.iter().map(|warning| format!("{name}: {warning}")));
    say(&format!("{}: {} states; {}", file.display(), done.truth.states().len(), words(&done.report)))?;
    Ok(json)
}

/// The report in a line.
fn words(report: &Report) -> String {
    let levels = &report.levels;
    let mut text = format!(
        "published poses late by {:.2} ms, off by {:.1} mm and {:.2} deg; IMU noise {:.3} m/s^2 and {:.4} rad/s a sample",
        report.delay_ms.value,
        report.published_position_error_mm,
        report.published_rotation_error_deg,
        levels.accel_sample_std,
        levels.gyro_sample_std
    );
    if let Some(held) = &report.held_out {
        text += &format!(
            "; {} poses kept out: {:.2} mm and {:.3} deg, {:.2} and {:.2} of what their noise allows",
            held.poses,
            1e3 * held.position_m,
            held.rotation_deg,
            held.position_whitened,
            held.rotation_whitened
        );
    }
    text
}
