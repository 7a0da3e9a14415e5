//! Which files belong together.

use crate::args::TrajectoryArgs;
use crate::ui::{Fault, errln, refuse};
use anyhow::Result;
use dpn_io::asl::Sequence;
use dpn_io::{IoError, printable};
use dpn_logs::is_bag;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// What `dpn run` calls the trajectory in its folder.
const OF_RUN: &str = "trajectory.tum";

/// An estimate and its truth.
pub(super) struct Case {
    /// Name of the sequence, where there are several.
    pub(super) sequence: Option<String>,
    /// Number of the estimate, in the order given.
    pub(super) number: usize,
    pub(super) truth: PathBuf,
    pub(super) estimate: PathBuf,
}

/// What estimates are called: the names of their files, or whole paths where two are alike.
pub(super) fn names(estimates: &[PathBuf]) -> Vec<String> {
    let short = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let alike = |path: &PathBuf| estimates.iter().filter(|other| short(other) == short(path)).count() > 1;
    let name = |path: &PathBuf| if alike(path) { path.display().to_string() } else { short(path) };
    estimates.iter().map(|path| printable(&name(path))).collect()
}

/// The cases, sequence by sequence.
pub(super) fn cases(args: &TrajectoryArgs, names: &[String]) -> Result<Vec<Case>> {
    if let Some(truth) = one(&args.truth)? {
        let case = |(number, path): (usize, &PathBuf)| {
            let estimate = one(path)?.ok_or_else(|| {
                Fault::new(format!("{} is a folder without a trajectory", path.display()))
                    .hint("name a file or a run's folder; folders of several belong to a folder of truths")
            })?;
            Ok(Case { sequence: None, number, truth: truth.clone(), estimate })
        };
        return args.estimates.iter().enumerate().map(case).collect();
    }
    let truths = all_in(&args.truth)?;
    let estimates = args.estimates.iter().map(|dir| all_in(dir)).collect::<Result<Vec<_>, _>>()?;
    let mut cases = Vec::new();
    for (sequence, truth) in &truths {
        for (number, files) in estimates.iter().enumerate() {
            match files.get(sequence) {
                Some(estimate) => cases.push(Case {
                    sequence: Some(sequence.clone()),
                    number,
                    truth: truth.clone(),
                    estimate: estimate.clone(),
                }),
                None => errln!("note: {} has nothing of {}", names[number], printable(sequence)),
            }
        }
    }
    if let Some(number) = (0..names.len()).find(|number| cases.iter().all(|case| case.number != *number)) {
        let message = format!(
            "{} and {} have no name of a sequence in common",
            args.truth.display(),
            args.estimates[number].display()
        );
        let hint = "call a sequence's file alike in both folders, whatever its ending: V1_01.csv, V1_01.tum";
        return refuse(message, hint);
    }
    Ok(cases)
}

/// The trajectory that a path names: a file, an ASL sequence's ground truth, a run's. None of a folder of several.
fn one(path: &Path) -> Result<Option<PathBuf>> {
    if !path.is_dir() {
        if path.exists() && !path.is_file() {
            let message =
                format!("{} is a pipe or a device, and a trajectory is read more than once", path.display());
            return refuse(message, "write it to a file first");
        }
        return Ok(Some(path.to_owned()));
    }
    let run = path.join(OF_RUN);
    if run.is_file() {
        return Ok(Some(run));
    }
    let truth = Sequence::open(path).ok().and_then(|sequence| sequence.ground_truth_path());
    Ok(truth.or_else(|| is_bag(path).then(|| path.to_owned())))
}

/// The trajectories in a folder, by name without ending.
fn all_in(dir: &Path) -> Result<BTreeMap<String, PathBuf>> {
    let mut all = BTreeMap::new();
    if dir.is_file() {
        let message = format!("{} is a file where the truth is a folder of sequences", dir.display());
        return refuse(message, "with a folder of truths, estimates are folders too");
    }
    let entries = std::fs::read_dir(dir).map_err(|error| IoError::reading(dir, error))?;
    for entry in entries {
        let path = entry.map_err(|error| IoError::reading(dir, error))?.path();
        let name = if path.is_dir() { path.file_name() } else { path.file_stem() };
        let name = name.unwrap_or_default().to_string_lossy().into_owned();
        let no_file = !(path.is_dir() || path.is_file());
        // What dpn says of a trajectory lies beside it under the same name.
        if no_file || name.starts_with('.') || path.extension().is_some_and(|ending| ending == "json") {
            continue;
        }
        let Some(file) = one(&path)? else { continue };
        if let Some(other) = all.insert(name, file) {
            let message = format!("{} and {} are of one name", other.display(), path.display());
            return refuse(message, "leave one of them in the folder");
        }
    }
    Ok(all)
}
