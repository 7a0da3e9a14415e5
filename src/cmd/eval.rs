//! `dpn eval`.

use super::{corpus, shipped};
use crate::args::EvalArgs;
use crate::ui::{Bar, Fault};
use anyhow::Result;
use dpn_core::Sensor;
use dpn_core::io::atomic_write;
use dpn_eval::figures::{Plot, Predicted, PredictedVsTrue, RmseVsSigma, save};
use dpn_eval::open_loop::{OpenLoop, Request, Row, networks, run as judge};
use dpn_eval::table::{Layout, render, write_csv};
use dpn_train::base::Base;
use dpn_train::windows::WINDOW;
use std::path::{Path, PathBuf};

pub(crate) fn run(args: &EvalArgs) -> Result<()> {
    let bases = bases(args.bases.as_deref())?;
    let networks = match &args.models {
        Some(dir) => networks::load_all(dir)?,
        None => shipped::networks()?,
    };
    let sensors = args
        .sensor
        .map_or_else(|| Sensor::ALL.to_vec(), |sensor| vec![sensor.into()]);
    let corpora = corpus::load(args.data.as_deref())?;
    let request = Request {
        corpora: &corpora,
        sensors: &sensors,
        bases: &bases,
        networks: &networks,
        regressors: true,
        seed: args.seed,
    };
    let result = judge(&request, &mut Bar::new())?;
    write_tables(&result.rows, &args.out)?;
    let mut pictures = Vec::new();
    for sensor in &sensors {
        pictures.extend(draw(&result, *sensor, &args.out)?);
    }
    pictures.extend(super::flight::draw(&corpora, &networks, &args.out)?);
    if args.json {
        println!("{}", serde_json::json!({ "rows": result.rows }));
    } else {
        println!("{}", render(&headline(&result.rows), Layout::Plain)?);
        println!("all rows: {}", args.out.join("open_loop.csv").display());
        for picture in pictures
            .iter()
            .filter(|path| path.extension().is_some_and(|e| e == "png"))
        {
            println!("picture:  {}", picture.display());
        }
    }
    Ok(())
}

/// The bases named, or those of the study.
fn bases(text: Option<&str>) -> Result<Vec<Base>> {
    let Some(text) = text else {
        return Ok(Base::STUDY.to_vec());
    };
    let names = text.split([';', ' ']).filter(|name| !name.is_empty());
    let bases: Result<Vec<Base>, _> = names.map(str::parse).collect();
    let bases = bases?;
    if bases.is_empty() {
        return Err(Fault::new("--bases names no base")
            .hint("for example --bases 'sg(11,2) sg(51,3)'")
            .into());
    }
    if let Some(error) = bases.iter().find_map(|base| base.filter().err()) {
        return Err(error.into());
    }
    Ok(bases)
}

/// Everything as CSV and as JSON lines.
fn write_tables(rows: &[Row], out: &Path) -> Result<()> {
    let mut csv = Vec::new();
    write_csv(rows, &mut csv)?;
    atomic_write(&out.join("open_loop.csv"), |file| file.write_all(&csv))?;
    let json = serde_json::to_string(&serde_json::json!({ "rows": rows }))? + "\n";
    atomic_write(&out.join("open_loop.json"), |file| {
        file.write_all(json.as_bytes())
    })?;
    Ok(())
}

/// The rows a reader asks for first: test windows; the paper's grid and label, continuous levels on the smoothest base,
/// total noise on raw signals; best first within each group.
fn headline(rows: &[Row]) -> Vec<Row> {
    let wanted = |row: &&Row| {
        row.split == "test"
            && match row.base.as_str() {
                "raw" => row.levels == "grid" && row.label == "sigma_tot",
                "sg(51,3)" => row.levels == "continuous" && row.label == "sigma_inj",
                _ => row.levels == "grid" && row.label == "sigma_inj",
            }
    };
    let mut rows: Vec<Row> = rows.iter().filter(wanted).cloned().collect();
    let group = |row: &Row| (row.sensor, row.data.clone());
    let order: Vec<String> = rows.iter().map(|row| row.base.clone()).collect();
    let place = |row: &Row| order.iter().position(|base| *base == row.base);
    rows.sort_by(|a, b| {
        group(a)
            .cmp(&group(b))
            .then(place(a).cmp(&place(b)))
            .then(a.rmse.total_cmp(&b.rmse))
    });
    rows
}

/// Predicted against true, and RMSE against sigma with the bound, on the best covered base.
fn draw(result: &OpenLoop, sensor: Sensor, out: &Path) -> Result<Vec<PathBuf>> {
    const SHOWN: [&str; 4] = ["pronet", "kernel-svr", "diff2", "sg(11,2)"];
    let mut files = Vec::new();
    let mut keep = |plot: &dyn Fn(&Path) -> Result<Vec<PathBuf>>, name: &str| -> Result<()> {
        files.extend(plot(&out.join(format!("open_loop_{name}_{sensor}")))?);
        Ok(())
    };
    let drawn = result
        .drawn
        .iter()
        .find(|d| d.sensor == sensor && d.levels == "grid" && d.base == "sg(11,2)");
    if let Some(drawn) = drawn.or_else(|| result.drawn.iter().find(|d| d.sensor == sensor)) {
        let named = SHOWN
            .iter()
            .filter_map(|name| drawn.estimates.iter().find(|(n, _)| n == name));
        let estimates = named
            .map(|(name, sigma)| (name.as_str(), sigma.as_slice()))
            .collect();
        let plot = PredictedVsTrue::new(&[Predicted {
            sensor,
            truth: &drawn.truth,
            estimates,
        }])?;
        keep(&|path| picture(&plot, path), "predicted")?;
        let rows: Vec<&Row> = result
            .rows
            .iter()
            .filter(|r| {
                r.sensor == sensor && r.split == "test" && r.base == drawn.base && r.levels == drawn.levels
            })
            .filter(|r| r.label == "sigma_inj" && SHOWN.contains(&r.estimator.as_str()))
            .collect();
        let plot = RmseVsSigma::new(&rows, WINDOW)?;
        keep(&|path| picture(&plot, path), "rmse_vs_sigma")?;
    }
    Ok(files)
}

fn picture(plot: &impl Plot, path: &Path) -> Result<Vec<PathBuf>> {
    Ok(save(plot, path)?)
}
