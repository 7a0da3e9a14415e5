//! The folder in which what is dear to make is kept.

use clap::Args;
use dpn_io::ResultPath;

/// Where tracks that were followed through images, and rows of runs, are kept.
#[derive(Debug, Clone, Args)]
pub(crate) struct CacheArgs {
    /// Folder that keeps tracks followed through images and every run's row, for other commands, shards and nodes; results do not depend on it.
    #[arg(long, value_name = "DIR")]
    pub(crate) cache: Option<ResultPath>,
    /// How much of tracks it may hold (500MB, 20GB, 1TB); what was least recently used goes first.
    #[arg(long, value_name = "SIZE", value_parser = size, default_value = "20GB")]
    pub(crate) cache_size: u64,
}

/// Bytes of a number with a unit: `20GB`, `1.5 MB`, `1000000`.
pub(super) fn size(text: &str) -> Result<u64, String> {
    let text = text.trim();
    let digits = text.find(|c: char| !c.is_ascii_digit() && c != '.').unwrap_or(text.len());
    let (number, unit) = text.split_at(digits);
    let factor = match unit.trim().to_ascii_lowercase().as_str() {
        "b" | "" => 1.0,
        "kb" => 1e3,
        "mb" => 1e6,
        "gb" => 1e9,
        "tb" => 1e12,
        _ => return Err(format!("`{unit}` is no unit of bytes, for example 4GB or 500MB")),
    };
    match number.parse::<f64>() {
        Ok(number) if number > 0.0 && number * factor >= 1.0 => Ok((number * factor) as u64),
        _ => Err(format!("`{text}` is no number of bytes, for example 4GB or 500MB")),
    }
}

#[cfg(test)]
mod tests {
    use super::size;

    #[test]
    fn sizes_are_numbers_with_units() {
        assert_eq!(size("20GB"), Ok(20_000_000_000));
        assert_eq!(size("1.5 mb"), Ok(1_500_000));
        assert_eq!(size("7"), Ok(7));
        for bad in ["", "GB", "-1GB", "0GB", "3 stones", "1e9"] {
            assert!(size(bad).is_err(), "{bad}");
        }
    }
}
