//! `dpn sweep status`.

use super::lasting::lasting;
use crate::args::SweepStatusArgs;
use crate::ui::outln;
use anyhow::Result;
use dpn_eval::sweeps::{ShardState, SweepFolder, SweepStatus, status};

/// Failures and broken-off shards that are named in the printed words; the JSON has all.
const SHOWN: usize = 10;

pub(crate) fn run(args: &SweepStatusArgs) -> Result<()> {
    let folder = SweepFolder::open(&args.sweep)?;
    if args.limits {
        let longest_s = folder.manifest.shard_s.iter().copied().fold(0.0, f64::max);
        return outln!("{} {}", folder.shards(), longest_s.ceil()).map_err(Into::into);
    }
    let found = status(&folder)?;
    if args.json {
        outln!("{}", serde_json::to_string(&found)?)?;
        return Ok(());
    }
    say(&folder, &found)
}

fn say(folder: &SweepFolder, found: &SweepStatus) -> Result<()> {
    let SweepStatus { done, cells, running, failed, .. } = found;
    let count = |state| found.shards.iter().filter(|shard| shard.state == state).count();
    outln!("{done} of {cells} cells done, {failed} failed")?;
    outln!(
        "{} shards: {} done, {running} running, {} waiting, {} broken off, {} with failed cells",
        found.shards.len(),
        count(ShardState::Done),
        count(ShardState::Waiting),
        count(ShardState::BrokenOff),
        count(ShardState::Failed)
    )?;
    match found.left_s {
        Some(0.0) => {}
        Some(seconds) => outln!("ends in about {}", lasting(seconds))?,
        None => outln!("nobody works on it")?,
    }
    for shard in &found.shards {
        if let (ShardState::Running, Some(by)) = (shard.state, &shard.by) {
            let (number, done, cells) = (shard.shard, shard.done, shard.cells);
            outln!("shard {number}: {done} of {cells}, by process {} on {}", by.process, by.node)?;
        }
    }
    let broken = found.shards.iter().filter(|shard| shard.state == ShardState::BrokenOff);
    for shard in broken.take(SHOWN) {
        outln!(
            "shard {}: broken off after {} of {}; {}",
            shard.shard,
            shard.done,
            shard.cells,
            folder.command(shard.shard)
        )?;
    }
    for shard in found.shards.iter().filter(|shard| shard.state == ShardState::Misplaced).take(SHOWN) {
        let (number, dir) = (shard.shard, folder.shard_dir(shard.shard));
        let dir = dir.display();
        outln!(
            "shard {number}: {dir} holds another shard's results; remove it, and `{}`",
            folder.command(number)
        )?;
    }
    let failures =
        found.shards.iter().flat_map(|shard| shard.failed.iter().map(move |line| (shard.shard, line)));
    for (shard, line) in failures.take(SHOWN) {
        outln!("shard {shard}: {} failed: {}", line.label, line.reason)?;
    }
    Ok(())
}
