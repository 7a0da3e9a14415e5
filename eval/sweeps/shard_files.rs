//! Names of the files of a sweep and of its shards.

/// A job's rows in its folder.
pub(super) const ROWS: &str = "rows.jsonl";
/// Cells that could not be run.
pub(super) const FAILED: &str = "failed.jsonl";

/// Reconciled ground truth that was made for the sweep, a folder a job; in the sweep's folder.
pub const TRUTH: &str = "truth";
