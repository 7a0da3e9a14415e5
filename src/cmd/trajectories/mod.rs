//! `dpn ape` and `dpn rpe`.

mod beliefs;
mod find;
mod judged;
mod say;

use super::apart;
use crate::args::{ApeArgs, DeltaUnit, MAX_DIFF_S, RpeArgs, TrajectoryArgs};
use crate::ui::{Fault, errln, out, print_pictures, refuse};
use anyhow::Result;
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use dpn_eval::metrics::{Compared, Comparing, MetricsError, PoseRelation, RpeSpec, absolute, relative};
use dpn_figures::{Cell, PoseBelief, save, trajectory_errors};
use dpn_io::{ResultPath, printable, read_counted_poses, read_poses};
use dpn_logs::{BagPoses, is_bag, read_bag_poses};
use find::{Case, cases, names};
use judged::{Judged, versus};
use std::path::{Path, PathBuf};

/// Trajectories that a picture tells apart.
const DRAWN: usize = 4;

pub(crate) fn ape(args: &ApeArgs) -> Result<()> {
    run(&args.of, "APE", None, absolute)
}

pub(crate) fn rpe(args: &RpeArgs) -> Result<()> {
    let (delta, unit) = match args.delta_unit {
        DeltaUnit::Frames => (args.delta, "f"),
        DeltaUnit::Metres => (args.delta, "m"),
        DeltaUnit::Degrees => (args.delta, "deg"),
        DeltaUnit::Radians => (args.delta.to_degrees(), "deg"),
        DeltaUnit::Seconds => (args.delta, "s"),
    };
    let mut text = format!("{delta}{unit}");
    text.push_str(if args.all_pairs { ":all_pairs" } else { "" });
    text.push_str(if args.pairs_from_reference { ":pairs_from_reference" } else { "" });
    let spec: RpeSpec = text.parse()?;
    let name = format!("RPE over {spec}");
    let seconds = (args.delta_unit == DeltaUnit::Seconds).then_some("-u s");
    run(&args.of, &name, seconds, |truth, estimate, by| {
        relative(truth, estimate, by, (&spec, args.delta_tol))
    })
}

fn run(
    args: &TrajectoryArgs,
    metric: &str,
    seconds: Option<&str>,
    compare: impl Fn(&[StampedPose], &[StampedPose], &Comparing) -> Result<Compared, MetricsError>,
) -> Result<()> {
    let by = comparing(args)?;
    let names = names(&args.estimates);
    let cases = cases(args, &names)?;
    let picture = args.save_plot.as_deref().map(stem).transpose()?;
    if let Some(stem) = &picture {
        let read: Vec<&PathBuf> = cases.iter().flat_map(|case| [&case.truth, &case.estimate]).collect();
        cases.iter().try_for_each(|case| apart::picture("--save_plot", &place(stem, case), &read))?;
    }
    let mut judged = Vec::new();
    for case in cases {
        let (truth, (estimate, mut beliefs), counted) = poses(&case.truth, &case.estimate)?;
        beliefs.iter_mut().for_each(|belief| belief.t = belief.t.plus_seconds(by.offset_s));
        if let (true, Some(flag)) = (counted, seconds.or_else(|| flag_of_stamps(args))) {
            let message = format!(
                "{flag} is in seconds, and {} and {} have no stamps",
                case.truth.display(),
                case.estimate.display()
            );
            let hint = "leave it away, or put a stamp before each pose or times.txt beside each file";
            return refuse(message, hint);
        }
        warn_of_start(args, &truth, &case);
        let compared = compare(&truth, &estimate, &by)
            .map_err(|error| fault(&error, &case, (&truth, &estimate), &by))?;
        judged.push(Judged { poses: estimate.len(), case, compared, beliefs, counted });
    }
    note_scales(&by, &names, &judged);
    let several = judged.iter().any(|one| one.case.sequence.is_some());
    let versus = if several { versus(&judged, names.len())? } else { Vec::new() };
    let pictures = picture.map(|stem| draw(&stem, &judged, &names, metric, &by)).transpose()?;
    if args.json {
        return Ok(out!("{}\n", say::json(metric, &by, &names, &judged, &versus))?);
    }
    let table = if several {
        say::sequences(metric, &by, &names, &judged, &versus)
    } else {
        say::one(metric, &by, &names, &judged)
    };
    out!("{}", table.console())?;
    Ok(print_pictures(&pictures.unwrap_or_default())?)
}

fn comparing(args: &TrajectoryArgs) -> Result<Comparing> {
    for (name, value) in [
        ("--t_max_diff", Some(args.t_max_diff)),
        ("--t_offset", Some(args.t_offset)),
        ("--t_start", args.t_start),
        ("--t_end", args.t_end),
    ] {
        // The seconds of a stamp in nanoseconds end at 9.2e9.
        if value.is_some_and(|value| !value.is_finite() || value.abs() > 9e9) {
            return refuse(format!("{name} is no number of seconds"), "give seconds, as stamps have them");
        }
    }
    if args.n_to_align.is_some() && !args.align && !args.correct_scale {
        return refuse("--n_to_align aligns nothing without -a or -s", "give -a, -s or both");
    }
    if let (Some(start), Some(end)) = (args.t_start, args.t_end)
        && start > end
    {
        return refuse(
            format!("--t_start {start} is after --t_end {end}"),
            "both are stamps; give the earlier one as --t_start",
        );
    }
    let stamp = |seconds: f64| Stamp::from_ns(0).plus_seconds(seconds);
    Ok(Comparing {
        relation: args.relation,
        align: args.align,
        correct_scale: args.correct_scale,
        align_origin: args.align_origin,
        n_to_align: args.n_to_align.map(|n| n as usize),
        max_diff_s: args.t_max_diff,
        offset_s: args.t_offset,
        from: args.t_start.map(stamp),
        to: args.t_end.map(stamp),
    })
}

/// A flag that was given and has no sense without stamps.
fn flag_of_stamps(args: &TrajectoryArgs) -> Option<&'static str> {
    let flags = [
        ("--t_start", args.t_start.is_some()),
        ("--t_end", args.t_end.is_some()),
        ("--t_offset", args.t_offset != 0.0),
        ("--t_max_diff", args.t_max_diff != MAX_DIFF_S),
    ];
    flags.into_iter().find(|(_, given)| *given).map(|(flag, _)| flag)
}

/// Says where `--t_start` is meant as seconds from the start, as it seems: it then leaves out nothing.
fn warn_of_start(args: &TrajectoryArgs, truth: &[StampedPose], case: &Case) {
    let (Some(start), [first, .., last]) = (args.t_start, truth) else { return };
    let begins = first.t.seconds_since(Stamp::from_ns(0));
    if begins - start > last.t.seconds_since(first.t) {
        let truth = case.truth.display();
        errln!(
            "warning: --t_start {start} leaves out nothing: it is a stamp, not seconds from the start, and {truth} begins at {begins:.2}"
        );
    }
}

/// Says which estimates are of another scale, where it counts and was not asked for.
fn note_scales(by: &Comparing, names: &[String], judged: &[Judged]) {
    let turned =
        matches!(by.relation, PoseRelation::RotPart | PoseRelation::AngleDeg | PoseRelation::AngleRad);
    if by.correct_scale || turned {
        return;
    }
    for (number, name) in names.iter().enumerate() {
        let of = judged.iter().filter(|one| one.case.number == number);
        let off: Vec<_> = of.filter_map(|one| Some((&one.case.sequence, one.times_as_large()?))).collect();
        let Some((sequence, times)) = off.first() else { continue };
        let on = match (sequence, off.len() - 1) {
            (None, _) => String::new(),
            (Some(sequence), 0) => format!(" on {}", printable(sequence)),
            (Some(sequence), more) => format!(" on {} and {more} more", printable(sequence)),
        };
        let times = *times;
        let millimetres = if (900.0..1100.0).contains(&times) { ": in millimetres?" } else { ";" };
        errln!(
            "note: {name}{on} is {} times as large as the truth{millimetres} -s takes the scale out",
            Cell::significant(times, 3).shown()
        );
    }
}

/// A bag, with the topic behind its name where one is given; none of other files.
fn bag(path: &Path) -> Option<(PathBuf, Option<String>)> {
    let text = path.to_string_lossy();
    match text.find(":/").filter(|_| !path.exists()) {
        Some(at) => Some((PathBuf::from(&text[..at]), Some(text[at + 1..].to_owned()))),
        None => is_bag(path).then(|| (path.to_owned(), None)),
    }
}

/// Poses, and how sure of them who estimated them is.
type Believed = (Vec<StampedPose>, Vec<PoseBelief>);

/// Those of a file or of a bag.
fn read(path: &Path) -> Result<Believed> {
    let Some((bag, topic)) = bag(path) else {
        let poses = read_poses(path)?;
        let beliefs = beliefs::of_run(path, &poses);
        return Ok((poses, beliefs));
    };
    let BagPoses { poses, covariances, remarks } = read_bag_poses(&bag, topic.as_deref())?;
    remarks.iter().for_each(|remark| errln!("warning: {}: {}", path.display(), printable(remark)));
    Ok((poses, beliefs::of_messages(&covariances)))
}

/// Poses of truth and estimate, and whether they are counted: two files without stamps belong together line by line.
fn poses(truth: &Path, estimate: &Path) -> Result<(Vec<StampedPose>, Believed, bool)> {
    let same = |a: &Path, b: &Path| Some(a.canonicalize().ok()? == b.canonicalize().ok()?);
    if same(truth, estimate) == Some(true) {
        let message = format!("{} is compared with itself", truth.display());
        return refuse(message, "name the truth first, then what is judged");
    }
    let counted = |path: &Path| match bag(path) {
        Some(_) => Ok(None),
        None => read_counted_poses(path),
    };
    if let (Some(truth_poses), Some(poses)) = (counted(truth)?, counted(estimate)?) {
        if truth_poses.len() != poses.len() {
            let (a, b) = (truth_poses.len(), poses.len());
            let message = format!(
                "{} has {a} poses without stamps and {} has {b}",
                truth.display(),
                estimate.display()
            );
            let hint =
                "poses without stamps belong together line by line: give as many, or stamps before each";
            return refuse(message, hint);
        }
        return Ok((truth_poses, (poses, Vec::new()), true));
    }
    Ok((read(truth)?.0, read(estimate)?, false))
}

/// What hinders a comparison, with the remedy.
fn fault(
    error: &MetricsError,
    case: &Case,
    (truth, estimate): (&[StampedPose], &[StampedPose]),
    by: &Comparing,
) -> anyhow::Error {
    let (of, against) = (case.estimate.display(), case.truth.display());
    let seconds = |t: Stamp| format!("{:.2}", t.seconds_since(Stamp::from_ns(0)));
    let span = |poses: &[StampedPose]| match poses {
        [] => "no pose".to_owned(),
        [only] => format!("one pose at {} s", seconds(only.t)),
        [first, .., last] => {
            format!("{} poses from {} to {} s", poses.len(), seconds(first.t), seconds(last.t))
        }
    };
    let fault = Fault::new(match error {
        MetricsError::TooFewPairs { what, needed, found } => format!(
            "{of} against {against}: {found} pairs of poses where {what} needs {needed}: {}, against {}",
            span(estimate),
            span(truth)
        ),
        other => format!("{of} against {against}: {other}"),
    });
    let hint = match error {
        MetricsError::TooFewPairs { .. } if by.from.is_some() || by.to.is_some() => {
            "--t_start and --t_end are stamps, not seconds from the start: give such as lie within both"
        }
        MetricsError::TooFewPairs { .. } => {
            "--t_offset SECONDS moves the estimate's stamps, --t_max_diff SECONDS pairs what is further apart"
        }
        MetricsError::Degenerate { .. } => "leave -a and -s away, or give --align_origin",
        MetricsError::NoStretch { .. } => "give another -d, or --all_pairs and -t SHARE",
        _ => return fault.into(),
    };
    fault.hint(hint).into()
}

/// Where a picture comes, without its ending.
fn stem(file: &Path) -> Result<PathBuf> {
    if file.file_name().is_none()
        || file.is_dir()
        || file.as_os_str().to_string_lossy().ends_with(std::path::is_separator)
    {
        let message = format!("--save_plot {}: a folder, and a picture needs a name", file.display());
        return refuse(message, "name a file in it: FILE.svg");
    }
    let ending = file.extension().map(|ending| ending.to_string_lossy().to_lowercase());
    match ending.as_deref() {
        Some("svg" | "pdf" | "png") => Ok(file.with_extension("")),
        Some("jpg" | "jpeg" | "eps") => {
            let message = format!("{}: pictures are SVG, PDF and PNG", file.display());
            refuse(message, "name FILE.svg or FILE.pdf")
        }
        _ => Ok(file.to_owned()),
    }
}

/// Where that of a case comes: of several sequences one each, its name behind the file's. Below the folder, for nobody named but one of a picture's files.
fn place(stem: &Path, case: &Case) -> ResultPath {
    let mut name = stem.file_name().unwrap_or_default().to_owned();
    if let Some(sequence) = &case.sequence {
        name.push(format!("-{sequence}"));
    }
    ResultPath::from(stem.parent().unwrap_or(stem)).join(name)
}

/// The pictures.
fn draw(
    stem: &Path,
    judged: &[Judged],
    names: &[String],
    metric: &str,
    by: &Comparing,
) -> Result<Vec<ResultPath>> {
    let mut files = Vec::new();
    for sequence in judged.chunk_by(|a, b| a.case.sequence == b.case.sequence) {
        let drawn = &sequence[..sequence.len().min(DRAWN)];
        let of = |one: &'_ Judged| names[one.case.number].clone();
        let of: Vec<(String, &Compared, &[PoseBelief])> =
            drawn.iter().map(|one| (of(one), &one.compared, &one.beliefs[..])).collect();
        let mut caption = say::how(by, sequence);
        if sequence.len() > DRAWN {
            let more = format!(" The first {DRAWN} of {} trajectories.", sequence.len());
            errln!("note:{more}");
            caption.push_str(&more);
        }
        let time = if sequence[0].counted { "pose" } else { "time [s]" };
        let plot = trajectory_errors(&of, (&say::what(metric, by), time), &caption)?;
        files.extend(save(&plot, place(stem, &sequence[0].case))?);
    }
    Ok(files)
}
