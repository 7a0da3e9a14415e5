//! Trajectories of another program by our metrics: the CSV table of absolute errors in `eval/published/`.
//!
//! `cargo run --release -p dpn-eval --example judge_peers -- PEERS DATA [TRUTH]`: PEERS holds `SEQUENCE.FACTOR.tum`, DATA the sequences, TRUTH their
//! reconciled ground truth as `dpn truth` writes it; without it the published one judges. `from_s` is as in `golden/vins_mono`.
#![allow(clippy::unwrap_used)]

use dpn_eval::closed_loop::Errors;
use dpn_eval::metrics::poses_of;
use dpn_io::asl::Sequence;
use dpn_io::read_tum;
use std::path::Path;

const FACTORS: [&str; 6] = ["x0.5", "x1", "x2", "x4", "x8", "x16"];

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let (peers, data) = (Path::new(&args[1]), Path::new(&args[2]));
    let started = concat!(env!("CARGO_MANIFEST_DIR"), "/../golden/vins_mono/ate_se3.csv");
    println!("sequence,from_s,{}", FACTORS.map(|factor| format!("ate_{factor}_m")).join(","));
    for row in csv::Reader::from_path(started).unwrap().records() {
        let row = row.unwrap();
        let name = &row[0];
        let mut sequence = Sequence::open(&data.join(name)).unwrap();
        if let Some(truth) = args.get(3) {
            sequence = sequence.with_reconciled_truth(Path::new(truth));
        }
        let truth = poses_of(&sequence.ground_truth().unwrap());
        let ates = FACTORS.map(|factor| {
            let estimate = read_tum(&peers.join(format!("{name}.{factor}.tum"))).unwrap();
            format!("{:.3}", Errors::of(&truth, &estimate, None, None).unwrap().ate_se3.unwrap())
        });
        println!("{},{},{}", &name[..5], &row[1], ates.join(","));
    }
}
