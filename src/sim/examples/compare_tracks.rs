//! Prints given track files and simulated tracks of the same sequences side by side, as a Markdown table.
//!
//! `cargo run -p dpn-sim --release --example compare_tracks -- DATA [SEED]`, DATA the folder with `euroc/` and `tracks/`.

#[path = "../tests/reprojection.rs"]
mod reprojection;

use dpn_core::Stamp;
use dpn_io::{asl, read_tracks};
use dpn_sim::tracks::{CameraSettings, RecordedPath, TracksConfig, simulate_tracks, summarise};
use reprojection::Reprojection;
use std::error::Error;
use std::path::Path;
use std::time::Instant;

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let data = arguments.next().ok_or("usage: compare_tracks DATA [SEED]")?;
    let seed = arguments.next().map_or(Ok(1), |seed| seed.parse())?;
    let data = Path::new(&data);
    let (config, camera) = (TracksConfig::default(), CameraSettings::default());
    println!("| sequence | tracks | frames | in a frame | mean life | median | sigma px | outliers | s |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for sequence in asl::discover(&data.join("euroc"))? {
        let stamps: Vec<Stamp> = sequence.camera_frames()?.iter().map(|frame| frame.t).collect();
        let given = read_tracks(&data.join("tracks").join(format!("{}.txt", sequence.name())))?;
        let truth = sequence.ground_truth()?;
        let start = Instant::now();
        let path = RecordedPath::new(&truth, &config.path)?;
        let ours = simulate_tracks(&config, &path, &stamps, seed)?;
        let seconds = start.elapsed().as_secs_f64();
        for (name, frames, seconds) in [("given", &given, None), ("ours", &ours, Some(seconds))] {
            let counts = summarise(frames);
            let fit = Reprojection::of(frames, &path, &camera, 8)?.ok_or("no track could be triangulated")?;
            println!(
                "| {} {name} | {} | {} | {:.1} | {:.1} | {} | {:.3} | {:.1} % | {} |",
                sequence.name(),
                counts.tracks,
                counts.frames,
                counts.mean_in_frame,
                counts.mean_life,
                counts.median_life,
                fit.sigma_px,
                100.0 * fit.outlier_share,
                seconds.map_or(String::new(), |seconds| format!("{seconds:.2}")),
            );
        }
    }
    Ok(())
}
