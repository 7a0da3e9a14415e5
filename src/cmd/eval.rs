//! `dpn eval`.

use super::{closed_loop, corpus, inertial, program, shipped, stop};
use crate::args::EvalArgs;
use crate::ui::{Bar, errln, outln, print_pictures, refuse, warn};
use anyhow::Result;
use dpn_core::{SampleRate, Sensor};
use dpn_eval::open_loop::{OpenLoopError, Request, Row, run as judge};
use dpn_figures::{rmse_vs_sigma, save};
use dpn_io::{FolderLock, ResultPath, write_file, write_json};
use dpn_papers::tables::open_loop_rows;
use dpn_pronet::range::LOUD;
use dpn_train::base::Base;
use dpn_train::corpus::Corpus;
use dpn_train::label::Label;
use dpn_train::split::Side;
use dpn_train::windows::WINDOW;
use std::collections::BTreeSet;

/// Folder of the results where none is named.
const OUT: &str = "runs/open-loop";
/// The base whose errors are drawn, where it is asked for.
const DRAWN: &str = "sg(11,2)";

pub(crate) fn run(args: &EvalArgs) -> Result<()> {
    match &args.inertial {
        Some(config) => inertial::eval(args, config),
        None if args.closed_loop => closed_loop::run(args),
        None => open_loop(args),
    }
}

fn open_loop(args: &EvalArgs) -> Result<()> {
    let out = &args.out.clone().unwrap_or_else(|| OUT.into());
    let bases = bases(args.bases.as_deref())?;
    let models = args.models.as_deref();
    let networks = shipped::judged(&shipped::or_of(models)?, models, &args.more_models)?;
    let sensors = args.sensor.map_or_else(|| Sensor::ALL.to_vec(), |sensor| vec![sensor]);
    let corpora = corpus::load(args.data.as_deref(), SampleRate::HZ_200)?;
    let request = Request {
        corpora: &corpora,
        sensors: &sensors,
        bases: &bases,
        networks: &networks,
        seed: args.seed,
        program: &program(),
    };
    let _lock = FolderLock::take(out)?;
    let stop = stop::on_ctrl_c("what was judged is kept, and the same command goes on from there")?;
    let cells = out.join("cells");
    let rows = stop::outcome(judge(&request, &cells, &stop, &mut Bar::new()), |error| {
        matches!(error, OpenLoopError::Stopped { .. })
    })?;
    write_tables(&rows, out)?;
    let pictures = draw(&request, &rows, out)?;
    // They served to go on with; rows and pictures are whole now.
    cells.remove_all()?;
    if args.json {
        outln!("{}", serde_json::json!({ "rows": rows }))?;
    } else {
        let shown = headline(&rows);
        for words in not_shown(&request, &shown) {
            errln!("note: {words}");
        }
        warn(out_of_range(&shown));
        outln!("{}", open_loop_rows(&shown).console())?;
        outln!("all rows: {}", out.join("open_loop.csv").display())?;
        print_pictures(&pictures)?;
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
        return refuse("--bases names no base", "for example --bases 'sg(11,2) sg(51,3)'");
    }
    if let Some(error) = bases.iter().find_map(|base| base.filter().err()) {
        return Err(error.into());
    }
    Ok(bases)
}

/// Everything as CSV and as JSON lines.
fn write_tables(rows: &[Row], out: &ResultPath) -> Result<()> {
    write_file(out.join("open_loop.csv"), open_loop_rows(rows).csv())?;
    Ok(write_json(out.join("open_loop.json"), &serde_json::json!({ "rows": rows }))?)
}

/// The rows a reader asks for first: test windows; the paper's grid and label, continuous levels on the smoothest base,
/// total noise on raw signals; best first within each group.
fn headline(rows: &[Row]) -> Vec<Row> {
    let wanted = |row: &&Row| {
        row.split == Side::Test
            && match row.base.as_str() {
                "raw" => row.levels == "grid" && row.label == Label::Total,
                "sg(51,3)" => row.levels == "continuous" && row.label == Label::Injected,
                _ => row.levels == "grid" && row.label == Label::Injected,
            }
    };
    let mut rows: Vec<Row> = rows.iter().filter(wanted).cloned().collect();
    let group = |row: &Row| (row.sensor, row.data.clone());
    let order: Vec<String> = rows.iter().map(|row| row.base.clone()).collect();
    let place = |row: &Row| order.iter().position(|base| *base == row.base);
    rows.sort_by(|a, b| {
        group(a).cmp(&group(b)).then(place(a).cmp(&place(b))).then(a.rmse.total_cmp(&b.rmse))
    });
    rows
}

/// Why the table lacks what a reader looks for: sequences, or networks.
fn not_shown(request: &Request<'_>, shown: &[Row]) -> Vec<String> {
    let mut words = Vec::new();
    for Corpus { name, members, .. } in request.corpora {
        if members.iter().all(|member| member.side == Side::Train) {
            words.push(format!(
                "{name}: no row, for the table shows test sequences and {} is to train on; give two sequences or more",
                members.iter().map(|member| member.name.as_str()).collect::<Vec<_>>().join(", ")
            ));
            continue;
        }
        for &sensor in request.sensors {
            let of_sensor = || request.networks.iter().filter(|network| network.sensor() == sensor);
            let trained: BTreeSet<String> =
                of_sensor().map(|n| format!("{} ({}, {})", n.base, n.levels, n.label)).collect();
            let rows = || shown.iter().filter(|row| row.data == *name && row.sensor == sensor);
            let bases: BTreeSet<(&str, &str, String)> =
                rows().map(|row| (row.base.as_str(), row.levels.as_str(), row.label.to_string())).collect();
            for (base, levels, label) in bases {
                if rows().any(|row| row.base == base && row.seeds > 0) {
                    continue;
                }
                let there = if trained.is_empty() {
                    format!("no network given is for the {sensor}")
                } else {
                    let trained = trained.iter().cloned().collect::<Vec<_>>().join(", ");
                    format!("a network is judged where it was trained, and those given were on {trained}")
                };
                words.push(format!(
                    "{name}, {sensor}, {base} ({levels}, {label}): no row of a network; {there}"
                ));
            }
        }
    }
    words
}

/// Where a network was asked about windows that its training had not.
fn out_of_range(rows: &[Row]) -> Option<String> {
    let of = |row: &Row| {
        let share = row.outside.filter(|share| *share > LOUD)?;
        Some(format!(
            "{} on {}'s {}, {} ({:.0} %)",
            row.estimator,
            row.data,
            row.sensor,
            row.base,
            100.0 * share
        ))
    };
    let all: Vec<String> = rows.iter().filter_map(of).collect();
    (!all.is_empty()).then(|| {
        format!(
            "OUT OF RANGE: windows are unlike anything the network was trained on, and its errors there are those of an extrapolation: {}",
            all.join("; ")
        )
    })
}

/// RMSE against sigma with the bound: a panel a sensor, on the paper's grid over [`DRAWN`], or over the first base where that one was not asked for.
fn draw(request: &Request<'_>, rows: &[Row], out: &ResultPath) -> Result<Vec<ResultPath>> {
    const SHOWN: [&str; 4] = ["pronet", "kernel-svr", "diff2", "sg(11,2)"];
    let bases: Vec<String> = request.bases.iter().map(Base::to_string).collect();
    let base = bases.iter().find(|base| *base == DRAWN).or(bases.first());
    let is_drawn = |row: &&Row| {
        row.split == Side::Test
            && Some(&row.base) == base
            && row.levels == "grid"
            && row.label == Label::Injected
            && SHOWN.contains(&row.estimator.as_str())
    };
    let drawn: Vec<&Row> = rows.iter().filter(is_drawn).collect();
    if drawn.is_empty() {
        return Ok(Vec::new());
    }
    Ok(save(&rmse_vs_sigma(&drawn, WINDOW)?, out.join("open_loop_rmse_vs_sigma"))?)
}
