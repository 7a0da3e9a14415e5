//! `dpn sweep collect`.

use crate::args::SweepCollectArgs;
use crate::cmd::closed_loop;
use crate::ui::{errln, outln};
use anyhow::Result;
use dpn_eval::closed_loop::read_rows;
use dpn_eval::sweeps::{JobSpec, SweepFolder, collect};

pub(crate) fn run(args: &SweepCollectArgs) -> Result<()> {
    let folder = SweepFolder::open(&args.sweep)?;
    let out = args.out.clone().unwrap_or_else(|| args.sweep.join("collected"));
    let done = collect(&folder, &out, args.without_failed)?;
    errln!(
        "{}: {} rows of {} shards, {} files beside them",
        done.out.display(),
        done.rows,
        folder.shards(),
        done.files
    );
    if done.failed > 0 {
        errln!("warning: without {} cells, which could not be run", done.failed);
    }
    match folder.manifest.jobs.as_slice() {
        [job] if matches!(job.spec, JobSpec::ClosedLoop(_)) && job.folder.as_os_str().is_empty() => {
            drop(folder);
            let rows = read_rows(&out.join("rows.jsonl"))?;
            closed_loop::say(&closed_loop::tables(out, rows)?, args.json)
        }
        jobs => {
            for job in jobs {
                outln!("{}", out.join(&job.folder).display())?;
            }
            Ok(())
        }
    }
}
