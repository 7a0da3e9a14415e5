//! `dpn noise convert`.

use crate::args::ConvertArgs;
use crate::ui::{errln, out, outln, warn};
use anyhow::Result;
use dpn_io::noise_formats::{Conversion, Given, NoiseCalibration, read};
use dpn_probe::allan::compare::implausible;

pub(crate) fn run(args: &ConvertArgs) -> Result<()> {
    // In the order of `Figure::ALL`.
    let typed = [&args.accel_noise, &args.accel_walk, &args.gyro_noise, &args.gyro_walk];
    let given = Given { rate: args.rate, ..Given::default() }.with_typed(typed.map(Option::as_deref))?;
    let source = match &args.file {
        Some(file) => read(file, args.from, &given)?,
        None => NoiseCalibration::typed(&given)?,
    };
    let warnings: Vec<String> = implausible(&source).into_iter().map(|finding| finding.text).collect();
    let conversion = Conversion::of(source, args.to, args.to_rate)?;
    if args.json {
        let mut json = conversion.json();
        json["warnings"] = warnings.into();
        outln!("{json}")?;
        return Ok(());
    }
    if args.from.is_none() && args.file.is_some() {
        errln!("read as {}", conversion.from);
    }
    for step in &conversion.steps {
        errln!("{step}");
    }
    warn(&warnings);
    for remark in &conversion.remarks {
        errln!("note: {remark}");
    }
    out!("{}", conversion.written.text)?;
    Ok(())
}
