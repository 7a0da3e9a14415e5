//! `dpn train --model inertial` and `dpn eval --inertial`: corrections of a gyroscope against trajectories.

use super::stop;
use crate::args::{EvalArgs, TrainArgs};
use crate::ui::{Bar, Fault, Interrupted, errln, out, outln};
use anyhow::{Context, Result};
use dpn_core::progress::Progress;
use dpn_figures::{Cell, Column, Table};
use dpn_inertial::{
    Course, Fitted, InertialConfig, Model, Residuals, SPANS_S, Score, Source, SpanScore, Training, Unknown,
    fit, sources,
};
use dpn_io::asl::Sequence;
use dpn_io::{FolderLock, atomic_write, config, read_poses};
use dpn_logs::{LogOptions, read_log};
use serde::Serialize;
use serde_json::json;
use std::path::{Path, PathBuf};

const CHECKPOINT: &str = "checkpoint.safetensors";
const NETWORK: &str = "network.safetensors";
/// Steps from one checkpoint to the next.
const EVERY: u64 = 50;

pub(super) fn train(args: &TrainArgs) -> Result<()> {
    let mut config: InertialConfig = config::load_over(args.config.as_deref(), &args.sets)?;
    config.seed = args.seed.unwrap_or(config.seed);
    let courses = courses(&config.train, args.data.as_deref())?;
    let mut training = Training::new(&config, &courses)?;
    let out =
        &args.out.clone().unwrap_or_else(|| format!("runs/train-{}-seed{}", config.name, config.seed).into());
    let _lock = FolderLock::take(out)?;
    let checkpoint = out.join(CHECKPOINT);
    match (checkpoint.read()?, args.resume) {
        (Some(bytes), true) => {
            let differs =
                || Fault::new(format!("{}: another configuration or other recordings", checkpoint.display()));
            training = training.resumed(&bytes, checkpoint.path())?.ok_or_else(|| {
                differs()
                    .hint("give what the run was started with, or start anew in another folder with --out")
            })?;
        }
        (Some(_), false) => {
            let stands = Fault::new(format!("{}: a run stands there already", out.display()));
            return Err(stands.hint("go on with it by --resume, or choose another folder with --out").into());
        }
        (None, true) => errln!("{}: no checkpoint there; it is begun anew", out.display()),
        (None, false) => {}
    }
    let stop = stop::on_ctrl_c("the last checkpoint is kept: add --resume to go on")?;
    let mut bar = Bar::new();
    bar.start("train", config.steps);
    loop {
        let done = training.train(EVERY, &stop, &mut bar);
        let bytes = training.to_bytes()?;
        atomic_write(&checkpoint, |file| file.write_all(&bytes))?;
        if done {
            break;
        }
        if stop.load(std::sync::atomic::Ordering::Relaxed) {
            return Err(
                Interrupted("stopped; the steps behind it are kept: add --resume to go on".into()).into()
            );
        }
    }
    bar.finish("");
    let (network, bytes) = (out.join(NETWORK), training.model().to_bytes()?);
    atomic_write(&network, |file| file.write_all(&bytes))?;
    let history = training.history();
    let last = &history[history.len().saturating_sub(EVERY as usize)..];
    let loss = last.iter().sum::<f64>() / last.len() as f64;
    let summary = json!({
        "config": config, "affine": training.affine(), "loss": loss,
        "data": courses.iter().map(|c| json!({ "name": c.name, "sha256": c.checksum })).collect::<Vec<_>>(),
    });
    let text = serde_json::to_string_pretty(&summary)? + "\n";
    atomic_write(out.join("summary.json"), |file| file.write_all(text.as_bytes()))?;
    if args.json {
        return Ok(outln!("{summary}")?);
    }
    let sequences = courses.len();
    Ok(outln!("{}: {} steps on {sequences} sequences, loss {loss:.3e}", network.display(), history.len())?)
}

pub(super) fn eval(args: &EvalArgs, path: &Path) -> Result<()> {
    let config: InertialConfig = config::load(path)?;
    if config.test.is_empty() {
        return Err(Fault::new(format!("{}: `test` names no sequence", path.display()))
            .hint("name some")
            .into());
    }
    let models = models(args.models.as_deref())?;
    let [train, test] = [&config.train, &config.test].map(|names| courses(names, args.data.as_deref()));
    let (train, test) = (train?, test?);
    for course in &test {
        let of_models = models.iter().flat_map(|model| &model.card.data);
        if train.iter().map(|c| &c.checksum).chain(of_models).any(|sum| *sum == course.checksum) {
            let text = format!(
                "{}: the very recording was trained on: its score would be of what was learned by heart",
                course.name
            );
            return Err(Fault::new(text).hint("leave it out of `test`, or train without it").into());
        }
        if course.truth_follows_gyro() {
            let name = &course.name;
            errln!(
                "note: {name}: its truth turns as its own gyroscope does, less a slow bias: what is scored there is that bias, and nothing quicker"
            );
        }
    }
    let affine = fit(&train.iter().collect::<Vec<_>>(), Unknown::All).context("no span with a true turn")?;
    // Scale and misalignment are no noise.
    let residuals = |course: &Course| {
        let gyro = course.gyro.iter().map(|reading| affine.affine.apply(reading)).collect();
        Residuals::of(&Course { gyro, ..course.clone() })
    };
    let known: Vec<(&str, Residuals)> =
        train.iter().map(|course| (platform(&course.name), residuals(course))).collect();
    let spans = |course: &Course| {
        let of = |is_meant: &dyn Fn(&str) -> bool| {
            known
                .iter()
                .filter(|(name, _)| is_meant(name))
                .map(|(_, residuals)| residuals)
                .collect::<Vec<_>>()
        };
        residuals(course).scores(&of(&|name| name == platform(&course.name)), &of(&|_| true))
    };
    let row = |course: &Course| Row {
        sequence: course.name.clone(),
        sources: sources(course, &affine.affine, &models, config.average_s),
        spans: spans(course),
    };
    let rows: Vec<Row> = test.iter().map(row).collect();
    let all = json!({ "data": config.name, "affine": affine, "sequences": rows });
    let out = &args.out.clone().unwrap_or_else(|| format!("runs/inertial-{}", config.name).into());
    let text = format!("{all}\n");
    atomic_write(out.join("inertial.json"), |file| file.write_all(text.as_bytes()))?;
    if args.json {
        return Ok(out!("{text}")?);
    }
    out!("{}", calibration(&affine))?;
    out!("{}\n", table(&rows).console())?;
    Ok(outln!("{}", span_table(&rows).console())?)
}

/// What a test sequence gave.
#[derive(Serialize)]
struct Row {
    sequence: String,
    sources: Vec<Source>,
    spans: Vec<SpanScore>,
}

/// A row a source, means over the sequences.
fn table(rows: &[Row]) -> Table {
    let columns =
        Column::all(&["rates"], &["AOE mean [deg]", "AOE worst", "ROE 1 s mean", "without bias, 1 s"]);
    let mut table = Table::new("inertial", "", columns);
    // Each sequence has the same sources.
    for (i, source) in rows[0].sources.iter().enumerate() {
        let mean = |of: fn(&Score) -> f64| {
            rows.iter().map(|row| of(&row.sources[i].score)).sum::<f64>() / rows.len() as f64
        };
        let worst = rows.iter().map(|row| row.sources[i].score.aoe_deg).fold(f64::NAN, f64::max);
        let numbers = [mean(|s| s.aoe_deg), worst, mean(|s| s.roe_deg), mean(|s| s.quick_deg)];
        table.row([vec![Cell::text(&source.name)], numbers.map(|v| Cell::number(v, 2)).to_vec()].concat());
    }
    table
}

/// What was flown in or driven: a sequence's name up to its first underscore (MH, V1, V2).
fn platform(name: &str) -> &str {
    name.split('_').next().unwrap_or(name)
}

/// A row a source of levels, means over the sequences.
fn span_table(rows: &[Row]) -> Table {
    let columns = Column::all(&["levels"], &["-log L, 0.1 s", "0.2 s", "0.5 s", "1 s", "NEES/9, 1 s"]);
    let mut table = Table::new("spans", "", columns);
    let all = || rows.iter().flat_map(|row| &row.spans);
    let mut names: Vec<&str> = Vec::new();
    for name in all().map(|score| score.name) {
        if !names.contains(&name) {
            names.push(name);
        }
    }
    for name in names {
        let mean = |span_s: f64, of: fn(&SpanScore) -> f64| {
            let own = all().filter(|score| score.name == name && score.span_s == span_s);
            let values: Vec<f64> = own.map(of).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        let numbers = SPANS_S.map(|span_s| Cell::number(mean(span_s, |score| score.nll), 1));
        let nees = Cell::number(mean(SPANS_S[3], |score| score.nees), 2);
        table.row([vec![Cell::text(name)], numbers.to_vec(), vec![nees]].concat());
    }
    table
}

/// The affine calibration with its intervals.
pub(super) fn calibration(fitted: &Fitted) -> String {
    let with = |value: f64, std: f64, digits: usize| format!("{value:.digits$} +- {:.digits$}", 1.96 * std);
    let rows = (0..3).map(|row| {
        let columns = (0..3).map(|c| with(fitted.affine.matrix[(row, c)], fitted.std.matrix[(row, c)], 4));
        format!(
            "  [{}]  {}",
            columns.collect::<Vec<_>>().join(", "),
            with(fitted.affine.bias[row], fitted.std.bias[row], 5)
        )
    });
    format!("rate = matrix * reading + bias [rad/s], 95 %:\n{}\n", rows.collect::<Vec<_>>().join("\n"))
}

/// Every network of a folder and of the folders in it.
fn models(dir: Option<&Path>) -> Result<Vec<Model>> {
    let Some(dir) = dir else { return Ok(Vec::new()) };
    let mut paths = Vec::new();
    let below = std::fs::read_dir(dir).with_context(|| format!("cannot list {}", dir.display()))?;
    for path in below.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()? {
        let inside = path.join(NETWORK);
        let is_file = path.is_file()
            && path.extension().is_some_and(|e| e == "safetensors")
            && !path.ends_with(CHECKPOINT);
        paths.extend(
            [path, inside]
                .into_iter()
                .find(|p| p.ends_with(NETWORK) && p.is_file() || is_file && p.is_file()),
        );
    }
    paths.sort();
    if paths.is_empty() {
        let text = format!("{}: no network there", dir.display());
        return Err(Fault::new(text).hint("dpn train --model inertial leaves network.safetensors").into());
    }
    let read = |path: PathBuf| {
        let bytes = std::fs::read(&path).with_context(|| format!("cannot read {}", path.display()))?;
        Ok(Model::from_bytes(&bytes, &path)?)
    };
    paths.into_iter().map(read).collect()
}

/// The named sequences below `data`: folders of ASL's layout, or `LOG=TRAJECTORY`.
fn courses(names: &[String], data: Option<&Path>) -> Result<Vec<Course>> {
    let below = |name: &str| data.unwrap_or(Path::new("")).join(name);
    let one = |name: &String| {
        let (log, truth) = match name.split_once('=') {
            Some((log, truth)) => (below(log), below(truth)),
            None => {
                let sequence = Sequence::open(&below(name))?;
                let truth = sequence.ground_truth_path();
                (
                    sequence.imu_path(),
                    truth.ok_or_else(|| {
                        super::along::no_ground_truth(sequence.dir(), "a correction is learned from it")
                    })?,
                )
            }
        };
        let recording = read_log(&log, &LogOptions::default())?.recording.held()?;
        Ok(Course::new(name, &recording, &read_poses(&truth)?)?)
    };
    names.iter().map(one).collect()
}
