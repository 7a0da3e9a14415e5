//! `dpn sweep`.

use super::examples;
use clap::{Args, Subcommand};
use dpn_io::ResultPath;
use std::path::PathBuf;
use std::str::FromStr;

/// Steps of a sweep.
#[derive(Debug, Subcommand)]
pub(crate) enum SweepWhat {
    /// List the cells of a plan, predict what they cost, cut them into shards; nothing is run.
    #[command(after_help = examples::SWEEP_PLAN)]
    Plan(SweepPlanArgs),
    /// Work off one shard, on any machine that has the sweep's folder and the data.
    #[command(after_help = examples::SWEEP_RUN)]
    Run(SweepRunArgs),
    /// Put the shards together into what one process would have left.
    #[command(after_help = examples::SWEEP_COLLECT)]
    Collect(SweepCollectArgs),
    /// How far a sweep is.
    #[command(after_help = examples::SWEEP_STATUS)]
    Status(SweepStatusArgs),
}

/// Flags of `dpn sweep plan`.
#[derive(Debug, Args)]
pub(crate) struct SweepPlanArgs {
    /// What is run (TOML, as the files of configs/sweep).
    #[arg(value_name = "PLAN.toml")]
    pub(crate) plan: PathBuf,
    /// So many shards.
    #[arg(long, value_name = "N", required_unless_present = "minutes", conflicts_with = "minutes", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub(crate) shards: Option<u64>,
    /// As many shards as end within so many minutes each, one thread a shard.
    #[arg(long, value_name = "M", value_parser = minutes)]
    pub(crate) minutes: Option<f64>,
    /// Folder of the sweep.
    #[arg(long, value_name = "SWEEP")]
    pub(crate) out: ResultPath,
    /// Folder of the data, over the plan's.
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// The kind of processor that will run it (x86_64-v3), where it is not as this one.
    #[arg(long, value_name = "NAME")]
    pub(crate) processor: Option<String>,
    /// Print the prediction as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Flags of `dpn sweep run`.
#[derive(Debug, Args)]
pub(crate) struct SweepRunArgs {
    /// Folder of the sweep.
    #[arg(value_name = "SWEEP")]
    pub(crate) sweep: ResultPath,
    /// Which: 3, 0-3, 1,4,7, or all, one after another; without it the number in SLURM_ARRAY_TASK_ID.
    #[arg(long, value_name = "K")]
    pub(crate) shard: Option<Shards>,
    /// Folder of the data, where it is not where the plan has it.
    #[arg(long, value_name = "DIR")]
    pub(crate) data: Option<PathBuf>,
    /// Folder of given tracks, where it is not where the plan has it.
    #[arg(long, value_name = "DIR")]
    pub(crate) tracks: Option<PathBuf>,
    /// Folder of reconciled ground truth, where it is not where the plan has it.
    #[arg(long, value_name = "DIR")]
    pub(crate) truth: Option<PathBuf>,
    /// Threads. Results do not depend on it; predicted times are of one.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = clap::value_parser!(u64).range(1..=4096))]
    pub(crate) threads: u64,
    /// Where tracks are kept.
    #[command(flatten)]
    pub(crate) cache: super::CacheArgs,
}

/// Flags of `dpn sweep collect`.
#[derive(Debug, Args)]
pub(crate) struct SweepCollectArgs {
    /// Folder of the sweep.
    #[arg(value_name = "SWEEP")]
    pub(crate) sweep: ResultPath,
    /// Folder of the results: a run's; of a paper, what `dpn paper` calls --work. Without it SWEEP/collected.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<ResultPath>,
    /// Put together what there is where cells could not be run.
    #[arg(long)]
    pub(crate) without_failed: bool,
    /// Print the rows of a closed loop as JSON on stdout instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Flags of `dpn sweep status`.
#[derive(Debug, Args)]
pub(crate) struct SweepStatusArgs {
    /// Folder of the sweep.
    #[arg(value_name = "SWEEP")]
    pub(crate) sweep: ResultPath,
    /// Print every shard as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
    /// Print two numbers: how many shards there are, and the seconds that the longest is predicted to take. For scripts that submit them.
    #[arg(long, conflicts_with = "json")]
    pub(crate) limits: bool,
}

/// Numbers of shards.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Shards {
    /// Every one.
    All,
    /// From and to, both included, several times.
    Ranges(Vec<(usize, usize)>),
}

impl FromStr for Shards {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "all" {
            return Ok(Self::All);
        }
        let range = |part: &str| {
            let (from, to) = part.split_once('-').unwrap_or((part, part));
            let (from, to) = (from.trim().parse().ok()?, to.trim().parse().ok()?);
            (from <= to).then_some((from, to))
        };
        let ranges: Option<Vec<(usize, usize)>> = text.split(',').map(range).collect();
        ranges
            .map(Self::Ranges)
            .ok_or_else(|| format!("`{text}` is neither all nor numbers as 3, 0-3 or 1,4,7"))
    }
}

impl Shards {
    /// The numbers, of `count` shards.
    pub(crate) fn numbers(&self, count: usize) -> Vec<usize> {
        match self {
            Self::All => (0..count).collect(),
            // What is beyond the last is refused by name where it is run.
            Self::Ranges(ranges) => {
                ranges.iter().flat_map(|(from, to)| *from..=(*to).min(count.max(*from))).collect()
            }
        }
    }
}

fn minutes(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(minutes) if minutes.is_finite() && minutes > 0.0 => Ok(minutes),
        _ => Err(format!("`{text}` is no number of minutes above 0")),
    }
}
