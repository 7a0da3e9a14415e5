//! Results and what is read, kept apart: asked before any work begins.

use crate::ui::refuse;
use anyhow::Result;
use dpn_figures::ENDINGS;
use dpn_io::ResultPath;
use std::path::Path;

/// Refuses a file of results, as `flag` names it, that is one of `inputs` or lies in a folder of theirs, a folder, or `-`.
pub(super) fn file<P: AsRef<Path>>(flag: &str, file: &Path, inputs: &[P]) -> Result<()> {
    if file == Path::new("-") || file.is_dir() {
        let message = format!("{flag} {} is no file that can be written", file.display());
        return refuse(message, "name a file");
    }
    let inside = |input: &Path, there: &Path| input.is_dir() && there.starts_with(input);
    keep((flag, file), file, inputs, inside, "name another file")
}

/// The same of a picture's files, `stem` with the endings of all that is written.
pub(super) fn picture<P: AsRef<Path>>(flag: &str, stem: &ResultPath, inputs: &[P]) -> Result<()> {
    ENDINGS.iter().try_for_each(|ending| file(flag, stem.with_ending(ending).path(), inputs))
}

/// Refuses a folder of results, as `flag` names it, that is a file or lies below one, or in which one of the files `names` is one of `inputs` or lies
/// side by side with what a folder of theirs holds; `NAME.*` are a picture's files. Folders of results below that of a log are their owner's wish.
pub(super) fn folder<P: AsRef<Path>>(
    flag: &str,
    dir: &ResultPath,
    names: &[&str],
    inputs: &[P],
) -> Result<()> {
    let dir = dir.path();
    if let Some(file) = dir.ancestors().find(|above| above.exists()).filter(|there| !there.is_dir()) {
        let message =
            format!("{flag} {}: {} is a file, and results come into a folder", dir.display(), file.display());
        return refuse(message, "name a folder, or one that is not there yet");
    }
    let beside = |input: &Path, there: &Path| there.parent() == Some(input);
    let files = |name: &&str| match name.strip_suffix(".*") {
        Some(picture) => ENDINGS.iter().map(|ending| format!("{picture}.{ending}")).collect(),
        None => vec![(*name).to_owned()],
    };
    names
        .iter()
        .flat_map(files)
        .try_for_each(|name| keep((flag, dir), &dir.join(name), inputs, beside, "name another folder"))
}

fn keep<P: AsRef<Path>>(
    (flag, named): (&str, &Path),
    written: &Path,
    inputs: &[P],
    within: impl Fn(&Path, &Path) -> bool,
    hint: &str,
) -> Result<()> {
    // What is not there yet is nobody's, and pipes and devices keep nothing.
    let Some(there) = written.canonicalize().ok().filter(|there| there.is_file()) else { return Ok(()) };
    let same =
        |input: &Path| input.canonicalize().is_ok_and(|input| input == there || within(&input, &there));
    match inputs.iter().map(AsRef::as_ref).find(|input| same(input)) {
        None => Ok(()),
        Some(input) => {
            let message = if input.is_dir() {
                format!(
                    "{flag} {} would write over {} in {}, which is read",
                    named.display(),
                    written.display(),
                    input.display()
                )
            } else {
                format!("{flag} {} would write over {}, which is read", named.display(), input.display())
            };
            refuse(message, hint)
        }
    }
}
