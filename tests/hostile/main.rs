//! Every command over files that nobody should have to read, and over damaged ones, with a gigabyte of address space: each is an answer or one
//! error with exit code 2, within ten seconds of CPU time.
//!
//! The short test takes what is small. The long ones (`cargo test --test hostile -- --ignored`) take the whole set, and `DPN_MUTATIONS` damaged files
//! a command, 5000 without it; they want a release build, `DPN_BIN` names it.
#![cfg(unix)]
#![allow(clippy::unwrap_used)]

mod judge;
mod mutate;
mod set;

use judge::{Case, judge};

/// A file that is read where every commit is tested has at most so many bytes.
const SMALL: usize = 300_000;

#[test]
fn small_hostile_files_are_answered() {
    let cases = set::all(SMALL);
    assert!(cases.len() > 100, "{}", cases.len());
    // One command each, by turns: what is left is the long test's.
    let one = |(i, case): (usize, Case)| {
        let command = case.commands[i % case.commands.len()].clone();
        Case { commands: vec![command], ..case }
    };
    println!("{}", judge(cases.into_iter().enumerate().map(one)));
}

#[test]
#[ignore = "minutes, with a release build in DPN_BIN"]
fn all_hostile_files_are_answered() {
    println!("{}", judge(set::all(usize::MAX)));
}

#[test]
fn some_damaged_files_are_answered() {
    println!("{}", judge(mutate::all(4)));
}

#[test]
#[ignore = "an hour, with a release build in DPN_BIN; DPN_MUTATIONS says how many files a command"]
fn many_damaged_files_are_answered() {
    let files = std::env::var("DPN_MUTATIONS").map_or(5000, |text| text.parse().unwrap());
    println!("{}", judge(mutate::all(files)));
}
