//! `dpn sweep run`.

use super::trainer::{CorpusTrainer, MODELS};
use crate::args::{Shards, SweepRunArgs};
use crate::cmd::{cache, program, shipped, stop};
use crate::ui::{Bar, Fault, Interrupted, errln};
use anyhow::Result;
use dpn_eval::sweeps::{Node, SweepError, SweepFolder, run_shard};
use dpn_io::ResultPath;
use dpn_pronet::network::Network;
use std::collections::VecDeque;

/// Where Slurm says which of an array's tasks this is.
const TASK: &str = "SLURM_ARRAY_TASK_ID";

pub(crate) fn run(args: &SweepRunArgs) -> Result<()> {
    let folder = SweepFolder::open(&args.sweep)?;
    let shards = chosen(args)?.numbers(folder.shards());
    let networks = if folder.manifest.models { own(&args.sweep.join(MODELS))? } else { shipped::networks()? };
    let cache = cache::open(&args.cache)?;
    let here = Node {
        program: program(),
        processor: dpn_pronet::processor(),
        data: args.data.as_deref(),
        tracks: args.tracks.as_deref(),
        truth: args.truth.as_deref(),
        networks: &networks,
        threads: args.threads as usize,
        cache: cache.as_ref(),
    };
    let data = args.data.clone().or_else(|| folder.manifest.data.clone());
    let mut trainer = CorpusTrainer::new(data);
    let stop = stop::on_ctrl_c("cells that were finished are kept, and the same command goes on from there")?;
    let (mut failed, mut held) = (None, Vec::new());
    let last = shards.len();
    let mut todo: VecDeque<usize> = shards.into();
    let mut begun = 0;
    while let Some(shard) = todo.pop_front() {
        begun += 1;
        match run_shard(&folder, shard, &here, &mut trainer, &stop, &mut Bar::new()) {
            Ok(done) => {
                let how = if done.was_there { "was there" } else { "done" };
                errln!("shard {shard}: {} cells, {how}", done.cells);
            }
            // Its holder may be through with it, or gone, when the others are done.
            Err(error) if error.is_held() && begun <= last && last > 1 => {
                errln!("shard {shard}: {error}; passed over until the others are done");
                held.push(shard);
            }
            // The shards after it have other cells.
            Err(error @ SweepError::Failed { .. }) => {
                errln!("shard {shard}: {error}");
                failed.get_or_insert(error);
            }
            Err(error) if error.is_stop() => {
                let words = format!("shard {shard} {error}; the same command goes on from there");
                return Err(Interrupted(words).into());
            }
            Err(error) => return Err(anyhow::Error::from(error).context(format!("shard {shard}"))),
        }
        if todo.is_empty() {
            todo.extend(held.drain(..));
        }
    }
    cache::say(cache.as_ref());
    failed.map_or(Ok(()), |error| Err(error.into()))
}

/// The networks that were put into the sweep's folder, a folder each.
fn own(models: &ResultPath) -> Result<Vec<Network>> {
    let mut all = Vec::new();
    for (folder, _) in models.list()? {
        for (name, _) in models.join(&folder).list()? {
            let file = models.join(&folder).join(name);
            all.push(Network::from_bytes(&file.read_existing()?, file.path())?);
        }
    }
    Ok(all)
}

/// The shards named, or the one that Slurm names.
fn chosen(args: &SweepRunArgs) -> Result<Shards, Fault> {
    let hint = "give --shard K, or start it as a task of an array: sbatch --array=0-11";
    match (&args.shard, std::env::var(TASK)) {
        (Some(shards), _) => Ok(shards.clone()),
        (None, Ok(text)) => match text.trim().parse() {
            Ok(task) => Ok(Shards::Ranges(vec![(task, task)])),
            Err(_) => Err(Fault::new(format!("{TASK} is {text:?}, and no number of a shard")).hint(hint)),
        },
        (None, Err(_)) => Err(Fault::new(format!("no shard is named, and there is no {TASK}")).hint(hint)),
    }
}
