//! The paper's own numbers that no other module needs: the split and its minutes, the RMSE of its networks.

use super::error::PaperError;
use dpn_core::Sensor;
use dpn_train::split::{Side, paper_side};

const SPLIT: (&str, &str) = ("split.csv", include_str!("split.csv"));
const MINUTES: (&str, &str) = ("minutes.csv", include_str!("minutes.csv"));
const OPEN_LOOP: (&str, &str) = ("open_loop.csv", include_str!("open_loop.csv"));
const CLOSED_LOOP: (&str, &str) = ("closed_loop.csv", include_str!("closed_loop.csv"));

/// A sequence of the paper.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Published {
    /// Short name, `MH_01`.
    pub(super) name: String,
    /// Its side.
    pub(super) side: Side,
    /// Rows of its IMU file.
    pub(super) rows: usize,
}

/// The eleven sequences, in the paper's order.
pub(super) fn sequences() -> Result<Vec<Published>, PaperError> {
    rows(SPLIT, |cells| {
        let name = *cells.first()?;
        Some(Published { name: name.to_owned(), side: paper_side(name)?, rows: cells.get(2)?.parse().ok()? })
    })
}

/// Minutes as printed: training, test, all.
pub(super) fn printed_minutes() -> Result<[f64; 3], PaperError> {
    let all = rows(MINUTES, |cells| cells.get(1)?.parse::<f64>().ok())?;
    match all[..] {
        [train, test, total] => Ok([train, test, total]),
        _ => Err(PaperError::Published { file: MINUTES.0, line: 1, text: "three rows are needed".into() }),
    }
}

/// RMSE of the paper's network of a sensor on the training and on the test windows \[unit of the sensor\].
pub(super) fn rmse(sensor: Sensor) -> Result<Option<[f64; 2]>, PaperError> {
    let all = rows(OPEN_LOOP, |cells| {
        let pair = [cells.get(2)?.parse().ok()?, cells.get(3)?.parse().ok()?];
        Some((*cells.first()? == sensor.name(), pair))
    })?;
    Ok(all.into_iter().find(|(of, _)| *of).map(|(_, pair)| pair))
}

/// Rate of improvement as the paper prints it \[%\], by short name.
pub(super) fn printed_improvement(sequence: &str) -> Result<Option<f64>, PaperError> {
    let all = rows(CLOSED_LOOP, |cells| Some((cells.first()?.to_string(), cells.get(6)?.parse().ok()?)))?;
    let of = |(name, value): (String, f64)| sequence.starts_with(&name).then_some(value);
    Ok(if paper_side(sequence).is_some() { all.into_iter().find_map(of) } else { None })
}

fn rows<T>(
    (file, text): (&'static str, &str),
    read: impl Fn(&[&str]) -> Option<T>,
) -> Result<Vec<T>, PaperError> {
    let lines = (1..).zip(text.lines()).skip(1).filter(|(_, line)| !line.trim().is_empty());
    lines
        .map(|(line, text)| {
            let cells: Vec<&str> = text.split(',').map(str::trim).collect();
            read(&cells).ok_or_else(|| PaperError::Published { file, line, text: text.to_owned() })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_figures_are_as_printed() {
        let all = sequences().unwrap();
        assert_eq!((all.len(), all[0].rows), (11, 36820));
        assert_eq!(all.iter().filter(|s| s.side == Side::Train).count(), 6);
        assert_eq!(printed_minutes().unwrap(), [12.5, 12.0, 22.5]);
        assert_eq!(rmse(Sensor::Gyro).unwrap(), Some([0.00162, 0.00185]));
        assert_eq!(printed_improvement("MH_02_easy").unwrap(), Some(-11.7));
        assert_eq!(printed_improvement("f01-hall-slow").unwrap(), None);
    }
}
