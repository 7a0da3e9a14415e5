//! `dpn compare`.

use super::{apart, log};
use crate::args::CompareArgs;
use crate::ui::{Fault, out, print_pictures, refuse, results};
use anyhow::Result;
use dpn_figures::{save_if_any, spectra_of_two};
use dpn_io::printable;
use dpn_probe::Finding;
use dpn_probe::compare::{Comparison, Side};
use dpn_probe::doctor::examine_log;
use std::path::Path;

pub(crate) fn run(args: &CompareArgs) -> Result<()> {
    let paths = [&args.first, &args.second];
    if let (Ok(a), Ok(b)) = (args.first.canonicalize(), args.second.canonicalize())
        && a == b
    {
        let message = format!("{} is compared with itself", args.first.display());
        return refuse(message, "name two logs of one sensor, the earlier one first");
    }
    apart::folder("--out", &args.out, &["compare.json", "spectra.*"], &paths)?;
    let side = |path: &Path| -> Result<Side> {
        let log = log::read_quietly(path, args.span, &args.how)?;
        let examination = examine_log(&log)?;
        Ok(Side::of(&log.recording, examination)?)
    };
    let sides = [side(paths[0])?, side(paths[1])?];
    let names = paths.map(|path| printable(&path.display().to_string()));
    let comparison = Comparison::of([&sides[0], &sides[1]]).ok_or_else(|| {
        let sick = sides.iter().zip(&names).find_map(|(side, name)| Some((side.bad()?, name)));
        let hint = match sick {
            Some((Finding { about, text, remedy, .. }, name)) => {
                format!("first {name}: {about}: {text} -> {}", remedy.unwrap_or("look at it"))
            }
            None => "both need ten seconds at rest, or some seconds of like motion".to_owned(),
        };
        Fault::new(format!("nothing in {} can be held against {}", names[1], names[0])).hint(hint)
    })?;
    let mut json = serde_json::to_value(&comparison)?;
    json["logs"] = names.to_vec().into();
    let plot = spectra_of_two([(&names[0], &sides[0].spectra), (&names[1], &sides[1].spectra)]);
    let files = save_if_any(plot, args.out.join("spectra"))?;
    // Last: where it lies, the rest does too.
    if results(args.out.join("compare.json"), &json, args.json)? {
        return Ok(());
    }
    out!("{}", comparison.page([&names[0], &names[1]]))?;
    Ok(print_pictures(&files)?)
}
