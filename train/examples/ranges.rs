//! Draws the windows that trained networks learned from once more, and writes what range they span into the networks' cards; their numbers stay as they are.
//!
//! `cargo run -p dpn-train --example ranges -- DATA WEIGHTS...`

use dpn_pronet::range::TrainedRange;
use dpn_pronet::weights::{Card, Weights};
use dpn_train::Device;
use dpn_train::config::TrainConfig;
use dpn_train::trainer::Trainer;
use dpn_train::{asl, corpus::to_train};
use std::error::Error;
use std::path::{Path, PathBuf};

type Result<T> = std::result::Result<T, Box<dyn Error>>;

fn main() -> Result<()> {
    let mut args = std::env::args_os().skip(1).map(PathBuf::from);
    let data = args.next().ok_or("give a folder of ASL sequences, then files of weights")?;
    for path in args {
        let weights = Weights::load(&path)?;
        let range = range(&weights, &data)?;
        let card = Card { range, ..weights.card().clone() };
        let bytes = Weights::new(weights.config(), weights.parameters().to_vec(), card).to_bytes()?;
        dpn_io::write_file(&path, &bytes)?;
        println!("{}: {range:?}", path.display());
    }
    Ok(())
}

fn range(weights: &Weights, data: &Path) -> Result<Option<TrainedRange>> {
    let run = weights.card().training.get("run").ok_or("its card does not say how it was trained")?;
    let config: TrainConfig = serde_json::from_value(run.clone())?;
    let corpus = to_train(asl::load(data, config.rate_hz)?).ok_or("no sequence there")?;
    Ok(Trainer::new(&config, &corpus, &Device::Cpu)?.trained_range(weights))
}
