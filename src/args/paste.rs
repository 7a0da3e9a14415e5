//! Which lines to paste.

use clap::Args;
use dpn_io::noise_formats::Format;

/// Lines of other programs.
#[derive(Debug, Args)]
pub(crate) struct PasteArgs {
    /// End with these programs' lines, ready to paste; several between commas: kalibr, openvins, orbslam3, okvis2, basalt, vins, ros, variances, datasheet, or all.
    #[arg(long, value_name = "FORMAT|all", default_value = "", hide_default_value = true)]
    pub(crate) paste: Formats,
    /// Bias walks too, where they are known: walks that an odometry learned have made other programs worse.
    #[arg(long)]
    pub(crate) walks: bool,
}

/// Programs' formats.
#[derive(Debug, Clone)]
pub(crate) struct Formats(pub(crate) Vec<Format>);

impl std::str::FromStr for Formats {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "" => Ok(Self(Vec::new())),
            "all" => Ok(Self(Format::ALL.to_vec())),
            names => {
                let all = names.split(',').map(|name| name.parse::<Format>().map_err(|e| e.to_string()));
                Ok(Self(all.collect::<Result<_, _>>()?))
            }
        }
    }
}
