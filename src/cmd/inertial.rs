//! `dpn train --model inertial` and `dpn eval --inertial`: corrections of a gyroscope against trajectories.

use super::{fit::matrix_page, shipped, stop};
use crate::args::{EvalArgs, TrainArgs};
use crate::ui::{Bar, Fault, Interrupted, errln, out, outln};
use anyhow::{Context, Result};
use dpn_core::estimate::{NoiseSpec, parse_list};
use dpn_core::progress::Progress;
use dpn_core::{NoiseModel, Sensor};
use dpn_eval::noise::Causal;
use dpn_figures::{Cell, Column, Table, TurnErrors, save, turn_errors};
use dpn_inertial::{
    Course, Fitted, InertialConfig, Levels, Model, Residuals, SPANS_S, Said, Score, Source, SpanScore,
    TURNS_S, Training, Turn, Unknown, chosen_speed, fit, same_rate, sources,
};
use dpn_io::asl::{ImuConfig, Sequence};
use dpn_io::{FolderLock, atomic_write, config, read_poses};
use dpn_logs::{LogOptions, read_log};
use dpn_pronet::network::Network;
use serde::Serialize;
use serde_json::json;
use std::path::Path;

const CHECKPOINT: &str = "checkpoint.safetensors";
const NETWORK: &str = "network.safetensors";
/// Steps from one checkpoint to the next.
const EVERY: u64 = 50;
/// Who says something of the noise, beside data sheets and the mean of training sequences: constants, features of the signal, networks.
const SPECS: &str = "x1; x4; diff2; sg(11,2); dualpronet; dualpronet(effective-s0)";
/// Levels along a recording are asked for so often \[Hz\].
const ASKED_HZ: f64 = 10.0;

pub(super) fn train(args: &TrainArgs) -> Result<()> {
    let mut config: InertialConfig = config::load_over(args.config.as_deref(), &args.sets)?;
    config.seed = args.seed.unwrap_or(config.seed);
    let courses: Vec<Course> =
        courses(&config.train, args.data.as_deref())?.into_iter().map(|(course, _)| course).collect();
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
        "config": training.config(), "affine": training.affine(), "loss": loss,
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
    let mut config: InertialConfig = config::load(path)?;
    if config.test.is_empty() {
        return Err(Fault::new(format!("{}: `test` names no sequence", path.display()))
            .hint("name some")
            .into());
    }
    let models = models(args.models.as_deref(), &config.name)?;
    let [train, test] = [&config.train, &config.test].map(|names| courses(names, args.data.as_deref()));
    let (train, test) = (train?, test?);
    let networks = models.iter().map(|model| ("a network of --models", model.card.rate));
    same_rate(train.iter().chain(&test).map(|(course, _)| (&*course.name, course.rate)).chain(networks))?;
    for (course, _) in &test {
        let of_models = models.iter().flat_map(|model| &model.card.data);
        if train.iter().map(|(c, _)| &c.checksum).chain(of_models).any(|sum| *sum == course.checksum) {
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
    let known: Vec<&Course> = train.iter().map(|(course, _)| course).collect();
    let affine = fit(&known, Unknown::All).context("no span with a true turn")?;
    config.speed = config.speed.or_else(|| Some(chosen_speed(&known)));
    let networks = shipped::networks()?;
    let specs = specs(&train[0].0, &networks)?;
    let residuals = |(course, data_sheet): &(Course, Option<Levels>)| -> Result<Residuals> {
        let said = said(course, *data_sheet, &specs)?;
        // Scale and misalignment are no noise.
        let gyro = course.gyro.iter().map(|reading| affine.affine.apply(reading)).collect();
        Ok(Residuals::of(&Course { gyro, ..course.clone() }, said))
    };
    let of_train = |one: &(Course, _)| Ok((one.0.name.clone(), residuals(one)?));
    let known = train.iter().map(of_train).collect::<Result<Vec<_>>>()?;
    let row = |one: &(Course, Option<Levels>)| -> Result<Row> {
        let (own, other): (Vec<_>, Vec<_>) =
            known.iter().partition(|(name, _)| platform(name) == platform(&one.0.name));
        let [own, other] =
            [own, other].map(|of| of.into_iter().map(|(_, residuals)| residuals).collect::<Vec<_>>());
        Ok(Row {
            sequence: one.0.name.clone(),
            sources: sources(&one.0, &affine, &models, &config),
            spans: residuals(one)?.scores(&own, &other),
        })
    };
    let rows = test.iter().map(row).collect::<Result<Vec<_>>>()?;
    let all = json!({ "data": config.name, "speed": config.speed, "affine": affine, "sequences": rows });
    let out = &args.out.clone().unwrap_or_else(|| format!("runs/inertial-{}", config.name).into());
    let text = format!("{all}\n");
    atomic_write(out.join("inertial.json"), |file| file.write_all(text.as_bytes()))?;
    let words = format!("{}: means over the test sequences {}.", config.name, config.test.join(", "));
    let files = save(&turn_errors(&turns(&rows), &words)?, out.join("inertial"))?;
    if args.json {
        return Ok(out!("{text}")?);
    }
    out!("{}", calibration(&affine))?;
    out!("{}\n", table(&rows).console())?;
    out!("{}\n", span_table(&rows).console())?;
    Ok(outln!("figure: {}", files[0].display())?)
}

/// The specs that the rate of the recordings allows.
fn specs<'a>(course: &Course, networks: &'a [Network]) -> Result<Vec<Causal<'a>>> {
    let one = |spec: &NoiseSpec| {
        Causal::new(spec, course.rate, networks)
            .inspect_err(|error| errln!("note: {error}; it has no row"))
            .ok()
    };
    Ok(parse_list(SPECS)?.iter().filter_map(one).collect())
}

/// What the data sheet and each spec say along a course.
fn said(course: &Course, data_sheet: Option<Levels>, specs: &[Causal<'_>]) -> Result<Vec<Said>> {
    let constant = |levels| Said { name: "data sheet".to_owned(), levels: vec![levels; course.len()] };
    let [second, hop] = [1.0, ASKED_HZ].map(|hz| (course.rate.hz() / hz).round() as usize);
    let mut all: Vec<Said> = data_sheet.map(constant).into_iter().collect();
    for spec in specs {
        let mut feed = spec.feed(second, hop)?;
        let mean = |axes: [f64; 3]| (axes.iter().map(|std| std * std).sum::<f64>() / 3.0).sqrt();
        let levels = course.samples(0).map(|sample| {
            let noise = feed.feed(&sample);
            Sensor::ALL.map(|sensor| mean(noise.of(sensor)))
        });
        all.push(Said { levels: levels.collect(), name: spec.spec().to_string() });
    }
    Ok(all)
}

/// Errors over spans, means over the sequences; of networks the first as it is and with all that is taken from it, and without raw ones, which are off by a hundred times more.
fn turns(rows: &[Row]) -> Vec<TurnErrors> {
    let sources = || rows[0].sources.iter().enumerate();
    let is_one = |source: &Source| source.name.starts_with("network ");
    let plain = sources().find(|(_, source)| is_one(source));
    let taken = plain.and_then(|(_, first)| {
        let more = format!("{} averaged", first.name);
        sources().rfind(|(_, source)| source.name.starts_with(&more))
    });
    let first: Vec<usize> = plain.into_iter().chain(taken).map(|(i, _)| i).collect();
    let drawn =
        sources().filter(|(i, source)| source.name != "raw" && (!is_one(source) || first.contains(i)));
    let one = |(i, source): (usize, &Source)| {
        let points = TURNS_S.into_iter().filter_map(|span_s| {
            let of =
                |row: &Row| row.sources[i].score.turns.iter().find(|turn| turn.span_s == span_s).copied();
            let turns = rows.iter().map(of).collect::<Option<Vec<_>>>()?;
            let mean = |of: fn(&Turn) -> f64| turns.iter().map(of).sum::<f64>() / turns.len() as f64;
            Some([span_s, mean(|turn| turn.roe_deg), mean(|turn| turn.quick_deg)])
        });
        TurnErrors { name: source.name.clone(), points: points.collect() }
    };
    drawn.map(one).collect()
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
        let second = |of: fn(&Turn) -> f64| {
            let all: Option<Vec<f64>> =
                rows.iter().map(|row| row.sources[i].score.second().map(of)).collect();
            all.map(|all| all.iter().sum::<f64>() / all.len() as f64)
        };
        let numbers =
            [Some(mean(|s| s.aoe_deg)), Some(worst), second(|t| t.roe_deg), second(|t| t.quick_deg)];
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
    let columns =
        Column::all(&["levels"], &["-log L, 0.1 s", "0.2 s", "0.5 s", "1 s", "NEES/9, 1 s", "in 95 %, 1 s"]);
    let mut table = Table::new("spans", "", columns);
    let all = || rows.iter().flat_map(|row| &row.spans);
    let mut names: Vec<&str> = Vec::new();
    for score in all() {
        if !names.contains(&score.name.as_str()) {
            names.push(&score.name);
        }
    }
    for name in names {
        let mean = |span_s: f64, of: fn(&SpanScore) -> f64| {
            let own = all().filter(|score| score.name == name && score.span_s == span_s);
            let values: Vec<f64> = own.map(of).collect();
            (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
        };
        let numbers = SPANS_S.map(|span_s| Cell::number(mean(span_s, |score| score.nll), 1));
        let last = [|score: &SpanScore| score.nees, |score: &SpanScore| score.inside];
        let last = last.map(|of| Cell::number(mean(SPANS_S[3], of), 2));
        table.row([vec![Cell::text(name)], numbers.to_vec(), last.to_vec()].concat());
    }
    table
}

/// The affine calibration with its intervals.
fn calibration(Fitted { affine, std, .. }: &Fitted) -> String {
    let number = |row, column| (affine.matrix[(row, column)], Some(std.matrix[(row, column)]));
    matrix_page(Sensor::Gyro, &number, &[0, 1, 2].map(|row| (-affine.bias[row], std.bias[row])))
}

/// The networks of a folder and of the folders in it whose configuration has this name.
fn models(dir: Option<&Path>, name: &str) -> Result<Vec<Model>> {
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
    let mut models = paths.iter().map(|path| Model::load(path)).collect::<Result<Vec<_>, _>>()?;
    let all = models.len();
    models.retain(|model| model.card.config.name == name);
    if models.is_empty() {
        let text = format!("{}: no network there of a configuration called `{name}`", dir.display());
        return Err(Fault::new(text).hint("dpn train --model inertial leaves network.safetensors").into());
    }
    if models.len() < all {
        errln!("note: {} networks of other configurations than `{name}` are passed over", all - models.len());
    }
    Ok(models)
}

/// The named sequences below `data`, folders of ASL's layout or `LOG=TRAJECTORY`, and what the data sheet beside them says of their noise.
fn courses(names: &[String], data: Option<&Path>) -> Result<Vec<(Course, Option<Levels>)>> {
    let below = |name: &str| data.unwrap_or(Path::new("")).join(name);
    let one = |name: &String| {
        let (log, truth, figures) = match name.split_once('=') {
            Some((log, truth)) => (below(log), below(truth), None),
            None => {
                let sequence = Sequence::open(&below(name))?;
                let truth = sequence.ground_truth_path().ok_or_else(|| {
                    super::along::no_ground_truth(sequence.dir(), "a correction is learned from it")
                })?;
                (sequence.imu_path(), truth, sequence.imu_config()?)
            }
        };
        let recording = read_log(&log, &LogOptions::default())?.recording.held()?;
        let of_sample = |figures: ImuConfig| {
            let rate = recording.rate();
            [figures.accel_noise.to_sample_std(rate).get(), figures.gyro_noise.to_sample_std(rate).get()]
        };
        let data_sheet = figures.map(of_sample);
        Ok((Course::new(name, &recording, &read_poses(&truth)?)?, data_sheet))
    };
    names.iter().map(one).collect()
}
