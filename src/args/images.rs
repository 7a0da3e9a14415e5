//! `dpn simulate images`.

use super::set::set;
use super::world::WorldArg;
use clap::Args;
use dpn_sim::RenderConfig;
use dpn_sim::tracks::World;
use std::path::PathBuf;

/// Flags of `dpn simulate images`. A flag overrides the configuration's key of the same meaning.
#[derive(Debug, Args)]
pub(crate) struct ImagesArgs {
    /// Folder of an ASL sequence with ground truth (EuRoC, TUM-VI), or name of a flight.
    #[arg(value_name = "SEQUENCE|FLIGHT")]
    pub(crate) source: String,
    /// Folder to write to, one ASL sequence; without it runs/images/NAME. It must not hold a sequence yet.
    #[arg(long, value_name = "DIR")]
    pub(crate) out: Option<PathBuf>,
    /// Seconds after the camera's first frame at which images begin.
    #[arg(long, value_name = "SECONDS")]
    pub(crate) from: Option<f64>,
    /// Seconds after the camera's first frame at which images end.
    #[arg(long, value_name = "SECONDS")]
    pub(crate) to: Option<f64>,
    /// Folder with reconciled ground truth, NAME.csv each, as `dpn truth` writes it; without it the published one.
    #[arg(long, value_name = "DIR")]
    pub(crate) truth: Option<PathBuf>,
    /// Seed of the world, the light and the sensor's noise.
    #[arg(long, default_value_t = 0)]
    pub(crate) seed: u64,
    /// Seed that the flight is flown with, as in `dpn simulate flight --seed`.
    #[arg(long, default_value_t = 0, value_name = "SEED")]
    pub(crate) flight_seed: u64,
    /// Configuration (TOML); without it the built-in default, which configs/images/euroc.toml repeats.
    #[arg(long, value_name = "FILE")]
    pub(crate) config: Option<PathBuf>,
    /// Kind of world.
    #[arg(long, value_enum)]
    world: Option<WorldArg>,
    /// How long the shutter is open in mean light, in seconds; 0 for no blur by motion.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    motion_blur: Option<f64>,
    /// Share of the time with little light.
    #[arg(long, value_name = "SHARE", allow_negative_numbers = true)]
    low_light: Option<f64>,
    /// Images of time t are taken from the pose at t + this, in seconds, as if the ground truth were late.
    #[arg(long, value_name = "SECONDS", allow_negative_numbers = true)]
    ground_truth_delay: Option<f64>,
    /// Write JPEG of this quality, as phones do, in place of PNG.
    #[arg(long, value_name = "1..100", value_parser = clap::value_parser!(u8).range(1..=100))]
    pub(crate) jpeg: Option<u8>,
    /// Write this share of the IMU's rows twice, evenly spread, as phones' logs have them.
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    pub(crate) repeated_rows: f64,
    /// Threads; without it as many as there are cores. The images do not depend on it.
    #[arg(long, value_name = "N")]
    pub(crate) threads: Option<usize>,
    /// Print what was written as JSON on stdout.
    #[arg(long)]
    pub(crate) json: bool,
}

fn share(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(share) if (0.0..=1.0).contains(&share) => Ok(share),
        _ => Err("a share is a number from 0 to 1".to_owned()),
    }
}

impl ImagesArgs {
    /// Puts what was typed over `config`.
    pub(crate) fn over(&self, config: &mut RenderConfig) {
        set(self.world.map(World::from), &mut config.world);
        set(self.motion_blur, &mut config.motion_blur.exposure_s);
        set(self.low_light, &mut config.low_light.share);
        set(self.ground_truth_delay, &mut config.ground_truth_delay_s);
    }
}
