//! Live runs under chance (`live`), and work on files: kills, stops, full disks and second writers at random moments of trainings, sweeps, papers and noise tracks: whoever calls the same command until it ends has
//! the bytes of a run that nobody disturbed, and nothing half-written beside them.
//!
//! At renames, too: a build with debug assertions ends itself at the one that `DPN_ABORT_AT_RENAME` numbers (`dpn_io::atomic_write`).
//!
//! The short tests disturb a few times. The long one (`cargo test --test chaos -- --ignored`) does so `DPN_CHAOS` times each, 100 without it; moments are
//! drawn from `DPN_CHAOS_SEED`, and every failure names the one it was found with.
#![cfg(unix)]
#![allow(clippy::unwrap_used)]

mod disturb;
mod live;
mod work;

use disturb::{Tally, Whole, at_rename, at_renames, full_disk, two_writers, undisturbed, until_it_ends};
use dpn_testing::forged::Draw;
use work::Work;

/// Disturbances of a kind of work where every commit is tested.
const SHORT: usize = 4;

/// The seed of what is drawn.
fn seed() -> u64 {
    std::env::var("DPN_CHAOS_SEED").map_or(20_261_122, |text| text.parse().unwrap())
}

/// Disturbs one kind of work so many times; what it leaves undisturbed.
fn chaos(of: Work, times: usize) -> Whole {
    let seed = seed();
    let mut draw = Draw::new(seed, of.name());
    let whole = undisturbed(of);
    let mut tally = Tally::default();
    while tally.disturbances() < times {
        until_it_ends(of, &whole, &mut draw, times - tally.disturbances(), &mut tally);
    }
    // A paper is made of the other three; by itself it is long.
    if of != Work::Paper || times > SHORT {
        full_disk(of, &whole);
        two_writers(of, &whole, &mut draw);
    }
    eprintln!("{}: {tally}, seed {seed}, {:.1} s undisturbed", of.name(), whole.seconds);
    whole
}

#[test]
fn a_training_survives() {
    chaos(Work::Train, SHORT);
}

#[test]
fn a_sweep_survives() {
    chaos(Work::Sweep, SHORT);
}

#[test]
fn an_open_loop_survives() {
    chaos(Work::OpenLoop, 3);
}

#[test]
fn a_paper_survives() {
    let whole = chaos(Work::Paper, 1);
    // One of its renames in the middle stands for all, which take half an hour.
    if cfg!(debug_assertions) {
        assert!(at_rename(Work::Paper, &whole, "30") && at_rename(Work::Paper, &whole, "30+"));
    }
}

#[test]
fn a_noise_track_survives() {
    chaos(Work::Noise, SHORT);
}

/// Disturbs the sensors of so many live runs.
fn live(plans: std::ops::Range<usize>) {
    let Some(dir) = dpn_testing::pack("motion") else { return };
    let recorded = live::Recorded::of(&dir.join("MH_01_easy_start"));
    plans.clone().for_each(|plan| recorded.survives(plan, seed()));
    eprintln!("live: {} plans of seed {}, nothing lost", plans.len(), seed());
}

#[test]
fn live_runs_survive() {
    live(0..1);
}

/// Ends work at every `every`-th of its renames; builds without debug assertions cannot be told to.
fn renames(of: Work, every: usize) {
    if cfg!(debug_assertions) {
        let seen = at_renames(of, &undisturbed(of), every);
        eprintln!("{}: ended before and after every {every}. of {seen} renames, nothing lost", of.name());
    }
}

#[test]
fn ended_at_some_renames_nothing_is_lost() {
    renames(Work::Noise, 1);
    renames(Work::Train, 20);
    renames(Work::Sweep, 16);
}

#[test]
#[ignore = "minutes"]
fn ended_at_every_rename_of_a_training_nothing_is_lost() {
    renames(Work::Train, 1);
}

#[test]
#[ignore = "minutes"]
fn ended_at_every_rename_of_a_sweep_nothing_is_lost() {
    renames(Work::Sweep, 1);
}

#[test]
#[ignore = "minutes"]
fn ended_at_every_rename_of_an_open_loop_nothing_is_lost() {
    renames(Work::OpenLoop, 1);
}

#[test]
#[ignore = "half an hour"]
fn ended_at_every_rename_of_a_paper_nothing_is_lost() {
    renames(Work::Paper, 1);
}

/// How often each is disturbed where there is time.
fn many() -> usize {
    std::env::var("DPN_CHAOS").map_or(100, |text| text.parse().unwrap())
}

#[test]
#[ignore = "minutes; DPN_CHAOS says how often it is disturbed"]
fn many_trainings_survive() {
    chaos(Work::Train, many());
}

#[test]
#[ignore = "minutes; DPN_CHAOS says how often it is disturbed"]
fn many_sweeps_survive() {
    chaos(Work::Sweep, many());
}

#[test]
#[ignore = "minutes; DPN_CHAOS says how often it is disturbed"]
fn many_open_loops_survive() {
    chaos(Work::OpenLoop, many());
}

#[test]
#[ignore = "minutes; DPN_CHAOS says how many"]
fn many_live_runs_survive() {
    live(0..many());
}

#[test]
#[ignore = "an hour; DPN_CHAOS says how often it is disturbed"]
fn many_papers_survive() {
    chaos(Work::Paper, many());
}
