//! Real images beside images rendered along the same poses, as the front-end sees them: the Markdown table of the book.
//!
//! `cargo run --release -p dpn-eval --example compare_cameras -- REAL SEQUENCE [SEEDS] [CONFIG]`: REAL is a folder with images, SEQUENCE one
//! whose ground truth reaches over the same stamps; figures of rendered images are means over SEEDS worlds (5). CONFIG: as for
//! `dpn simulate images`.
#![allow(clippy::unwrap_used)]

#[path = "../tests/camera/mod.rs"]
mod camera;

use camera::{CameraFigures, lens_error, matches};
use dpn_core::Stamp;
use dpn_eval::closed_loop::{SequenceSet, TrackSource};
use dpn_io::ImageFolder;
use dpn_io::asl::Sequence;
use dpn_sim::RenderConfig;
use std::path::Path;

fn main() {
    let args: Vec<String> = std::env::args().collect();
    let (real, full) = (Path::new(&args[1]), Path::new(&args[2]));
    let seeds: u64 = args.get(3).map_or(5, |n| n.parse().unwrap());
    let config =
        args.get(4).map_or_else(RenderConfig::default, |path| dpn_io::config::load(Path::new(path)).unwrap());
    let stamps: Vec<Stamp> = ImageFolder::open(&Sequence::open(real).unwrap()).unwrap().stamps().collect();
    let (first, last) = (stamps[0], stamps[stamps.len() - 1]);
    let middle = first.plus_seconds(8.5);
    let folder = TrackSource::Images { skip_missing: false };
    let drawn = TrackSource::Rendered(Box::new(config));
    let (real, drawn) = (SequenceSet::one(real, folder).unwrap(), SequenceSet::one(full, drawn).unwrap());
    for (name, span) in [("first half", [first, middle]), ("second half", [middle, last])] {
        let truth = CameraFigures::of(&real, 0, 0, span).unwrap();
        let each: Vec<_> = (0..seeds).map(|seed| CameraFigures::of(&drawn, 0, seed, span).unwrap()).collect();
        let mean = CameraFigures::mean(&each);
        println!("\n| {name} | real | rendered | ratio | seeds, least and most |\n|---|---|---|---|---|");
        for (i, ((what, of_real), (_, of_drawn))) in truth.named().into_iter().zip(mean.named()).enumerate() {
            let values = each.iter().map(|figures| figures.named()[i].1);
            let least = values.clone().fold(f64::MAX, f64::min);
            let most = values.fold(f64::MIN, f64::max);
            let ratio = of_drawn / of_real;
            println!("| {what} | {of_real:.4} | {of_drawn:.4} | {ratio:.2} | {least:.4} to {most:.4} |");
        }
    }
    println!(
        "\nMedian distance from the epipolar lines, second half, px: without and with the lens error that fits the first half"
    );
    for (name, set) in [("real", &real), ("rendered", &drawn)] {
        let [fitted, judged] =
            [[first, middle], [middle, last]].map(|span| matches(set, 0, 0, span).unwrap());
        let [without, with] = lens_error(&fitted, &judged).unwrap();
        println!("{name}: {without:.4}, {with:.4}");
    }
}
