//! `dpn data`.

use crate::args::{DataArgs, DataFileArgs, DataWhat};
use crate::ui::{Fault, outln};
use anyhow::Result;
use dpn_io::asl::{DataPack, PackedPart, pack};
use std::path::Path;

pub(crate) fn run(args: &DataArgs) -> Result<()> {
    match &args.what {
        DataWhat::Pack(args) => Ok(outln!("{}", words(&args.out, &pack(&args.dir, &args.out)?)?)?),
        DataWhat::List(args) => list(args),
        DataWhat::Check(args) => check(args),
    }
}

/// A pack in a line.
fn words(path: &Path, pack: &DataPack) -> Result<String> {
    let parts = pack.parts();
    let mut sequences: Vec<&str> = parts.iter().map(|part| part.sequence.as_str()).collect();
    sequences.dedup();
    let bytes = std::fs::metadata(path)?.len() as f64 / 1e6;
    Ok(format!(
        "{}: {} sequences, {bytes:.1} MB; images in {}",
        path.display(),
        sequences.len(),
        pack.folder().display()
    ))
}

fn list(args: &DataFileArgs) -> Result<()> {
    let pack = DataPack::open(&args.file)?;
    if args.json {
        let part = |p: &PackedPart| serde_json::json!({ "sequence": p.sequence, "file": p.file, "rows": p.rows, "bytes": p.bytes });
        let parts: Vec<_> = pack.parts().iter().map(part).collect();
        return Ok(outln!("{}", serde_json::json!({ "images": pack.folder(), "parts": parts }))?);
    }
    outln!("{}", words(&args.file, &pack)?)?;
    let mut above = String::new();
    for part in pack.parts() {
        if part.sequence != above {
            outln!("{}", part.sequence)?;
            above.clone_from(&part.sequence);
        }
        let rows = part.rows.map_or_else(String::new, |rows| format!("{rows:>9} rows"));
        outln!("  {:<40}{rows:>14}{:>12} bytes", part.file, part.bytes)?;
    }
    Ok(())
}

fn check(args: &DataFileArgs) -> Result<()> {
    let pack = DataPack::open(&args.file)?;
    let (words, parts) = (words(&args.file, &pack)?, pack.parts().len());
    let faults: Vec<String> = pack.faults()?.iter().map(ToString::to_string).collect();
    if args.json {
        outln!("{}", serde_json::json!({ "parts": parts, "faults": faults }))?;
    } else {
        faults.iter().try_for_each(|fault| outln!("{fault}"))?;
    }
    if !faults.is_empty() {
        let what = format!("{}: {} column(s) damaged", args.file.display(), faults.len());
        return Err(Fault::new(what).hint("copy the file again, or pack the data again").into());
    }
    if !args.json {
        outln!("{words}; {parts} parts are whole")?;
    }
    Ok(())
}
