//! `dpn ape` and `dpn rpe`: evo's options by evo's names.

use clap::Args;
use dpn_eval::metrics::PoseRelation;
use std::path::PathBuf;

/// Farthest that the stamps of a pair are apart unless told otherwise \[s\].
pub(crate) const MAX_DIFF_S: f64 = 0.01;

/// Trajectories, and how they are brought together.
#[derive(Debug, Args)]
pub(crate) struct TrajectoryArgs {
    /// True poses: a trajectory of TUM's or KITTI's, EuRoC's ground truth, folder of an ASL sequence, or bag (BAG:/TOPIC where it has several); or a folder of those,
    /// a sequence each.
    #[arg(value_name = "TRUTH")]
    pub(crate) truth: PathBuf,
    /// Trajectories to be judged, of the same kinds or a run's folder; of a folder of truths folders with the same names of files or runs, of which the first
    /// is what the others are compared with.
    #[arg(value_name = "ESTIMATE", required = true, num_args = 1..)]
    pub(crate) estimates: Vec<PathBuf>,
    /// What of an error is counted: trans_part, rot_part, angle_deg, angle_rad, full, point_distance.
    #[arg(short = 'r', long = "pose_relation", value_name = "RELATION", default_value = "trans_part", value_parser = relation)]
    pub(crate) relation: PoseRelation,
    /// Align by Umeyama's method, without scale.
    #[arg(short, long)]
    pub(crate) align: bool,
    /// Correct the scale by Umeyama's method; with -a align by it, too.
    #[arg(short = 's', long = "correct_scale")]
    pub(crate) correct_scale: bool,
    /// Put the first pose on the truth's.
    #[arg(long = "align_origin", conflicts_with = "align")]
    pub(crate) align_origin: bool,
    /// Poses that are aligned by, from the first on, three or more; without it all. With -a or -s.
    #[arg(long = "n_to_align", value_name = "N", value_parser = clap::value_parser!(u32).range(3..))]
    pub(crate) n_to_align: Option<u32>,
    /// Farthest that the stamps of a pair are apart.
    #[arg(long = "t_max_diff", value_name = "SECONDS", default_value_t = MAX_DIFF_S)]
    pub(crate) t_max_diff: f64,
    /// Added to the estimates' stamps.
    #[arg(long = "t_offset", value_name = "SECONDS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub(crate) t_offset: f64,
    /// First stamp that is looked at: seconds as stamps have them (1403636625.4), not from the start.
    #[arg(long = "t_start", value_name = "STAMP", allow_negative_numbers = true)]
    pub(crate) t_start: Option<f64>,
    /// Last stamp that is looked at.
    #[arg(long = "t_end", value_name = "STAMP", allow_negative_numbers = true)]
    pub(crate) t_end: Option<f64>,
    /// Draw paths from above, coloured by error, and errors, positions and angles over time: FILE.svg or FILE.pdf, with all of SVG, PDF, PNG and CSV beside each other.
    #[arg(long = "save_plot", alias = "save-plot", value_name = "FILE")]
    pub(crate) save_plot: Option<PathBuf>,
    /// Print everything as JSON on stdout instead of the table.
    #[arg(long)]
    pub(crate) json: bool,
}

/// Flags of `dpn ape`.
#[derive(Debug, Args)]
pub(crate) struct ApeArgs {
    /// What is compared, and how.
    #[command(flatten)]
    pub(crate) of: TrajectoryArgs,
}

/// Flags of `dpn rpe`.
#[derive(Debug, Args)]
pub(crate) struct RpeArgs {
    /// What is compared, and how.
    #[command(flatten)]
    pub(crate) of: TrajectoryArgs,
    /// Length of a stretch.
    #[arg(short, long, value_name = "NUMBER", default_value_t = 1.0, value_parser = length, allow_negative_numbers = true)]
    pub(crate) delta: f64,
    /// Its unit.
    #[arg(short = 'u', long = "delta_unit", value_name = "UNIT", value_enum, default_value_t = DeltaUnit::Frames)]
    pub(crate) delta_unit: DeltaUnit,
    /// How far a stretch's length may be off, as a share of it; with --all_pairs.
    #[arg(
        short = 't',
        long = "delta_tol",
        value_name = "SHARE",
        default_value_t = 0.1,
        value_parser = share,
        allow_negative_numbers = true,
        requires = "all_pairs"
    )]
    pub(crate) delta_tol: f64,
    /// A stretch from every pose, instead of one where the last ended.
    #[arg(long = "all_pairs")]
    pub(crate) all_pairs: bool,
    /// Measure stretches along the truth instead of the estimate.
    #[arg(long = "pairs_from_reference")]
    pub(crate) pairs_from_reference: bool,
}

/// Unit of a stretch's length.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum DeltaUnit {
    /// Poses.
    #[value(name = "f")]
    Frames,
    /// Metres.
    #[value(name = "m")]
    Metres,
    /// Degrees turned.
    #[value(name = "d")]
    Degrees,
    /// Radians turned.
    #[value(name = "r")]
    Radians,
    /// Seconds; evo has none.
    #[value(name = "s")]
    Seconds,
}

fn length(text: &str) -> Result<f64, String> {
    let above = |v: &f64| v.is_finite() && *v > 0.0;
    text.parse()
        .ok()
        .filter(above)
        .ok_or_else(|| "give a length above 0, for example 1; -u says its unit".to_owned())
}

fn share(text: &str) -> Result<f64, String> {
    let part = |v: &f64| (0.0..1.0).contains(v);
    text.parse()
        .ok()
        .filter(part)
        .ok_or_else(|| "give a share from 0 to below 1: 0.1 is ten per cent".to_owned())
}

fn relation(text: &str) -> Result<PoseRelation, String> {
    PoseRelation::called(text).ok_or_else(|| format!("known are {}", PoseRelation::names()))
}
