//! Kills, stops, full disks and second writers at random moments of trainings, sweeps and papers: whoever calls the same command until it ends has
//! the bytes of a run that nobody disturbed, and nothing half-written beside them.
//!
//! The short tests disturb a few times. The long one (`cargo test --test chaos -- --ignored`) does so `DPN_CHAOS` times each, 100 without it; moments are
//! drawn from `DPN_CHAOS_SEED`, and every failure names the one it was found with.
#![cfg(unix)]
#![allow(clippy::unwrap_used)]

mod disturb;
mod work;

use disturb::{Draw, Tally, full_disk, two_writers, undisturbed, until_it_ends};
use work::Work;

/// Disturbances of a kind of work where every commit is tested.
const SHORT: usize = 6;

/// Disturbs one kind of work so many times.
fn chaos(of: Work, times: usize) {
    let seed = std::env::var("DPN_CHAOS_SEED").map_or(20_261_122, |text| text.parse().unwrap());
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
    chaos(Work::Paper, 1);
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
#[ignore = "an hour; DPN_CHAOS says how often it is disturbed"]
fn many_papers_survive() {
    chaos(Work::Paper, many());
}
