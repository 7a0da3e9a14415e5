//! `dpn noise convert`.

use crate::args::ConvertArgs;
use crate::ui::{errln, out, outln};
use anyhow::Result;
use dpn_core::noise::Figure;
use dpn_io::noise_formats::{FormatError, Given, NoiseCalibration, Quantity, read, write};

pub(crate) fn run(args: &ConvertArgs) -> Result<()> {
    let given = Given { rate: args.rate, quantities: quantities(args)?, keep_zeros: false };
    let source = match &args.file {
        Some(file) => read(file, args.from, &given)?,
        None => NoiseCalibration::typed(&given)?,
    };
    let mut figures = source.figures;
    figures.rate = args.to_rate.or(figures.rate);
    let written = write(&figures, args.to, |_| None)?;
    if args.json {
        let all = serde_json::json!({
            "from": source.format, "to": written.format, "rate_hz": figures.rate, "figures": figures,
            "steps": source.steps.iter().chain(&written.steps).collect::<Vec<_>>(),
            "remarks": source.remarks.iter().chain(&written.remarks).collect::<Vec<_>>(),
            "text": written.text,
        });
        outln!("{all}")?;
        return Ok(());
    }
    if args.from.is_none() && args.file.is_some() {
        errln!("read as {}", source.format);
    }
    for step in source.steps.iter().chain(&written.steps) {
        errln!("{step}");
    }
    for remark in source.remarks.iter().chain(&written.remarks) {
        errln!("note: {remark}");
    }
    out!("{}", written.text)?;
    Ok(())
}

/// What was typed with its units.
fn quantities(args: &ConvertArgs) -> Result<Vec<Quantity>> {
    let typed = [
        (Figure::AccelWhite, &args.accel_noise),
        (Figure::GyroWhite, &args.gyro_noise),
        (Figure::AccelWalk, &args.accel_walk),
        (Figure::GyroWalk, &args.gyro_walk),
    ];
    let quantities = typed.into_iter().filter_map(|(figure, text)| Some((figure, text.as_deref()?)));
    quantities
        .map(|(figure, text)| {
            Quantity::parse(text, figure).map_err(|problem| {
                let place = format!("--{}", figure.flag());
                FormatError::Quantity { place, problem }.into()
            })
        })
        .collect()
}
