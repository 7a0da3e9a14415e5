//! Other people's closed loops, built in: the paper's table and VINS-Mono on the given tracks.

use super::error::ClosedLoopError;
use dpn_train::split::paper_side;

/// The paper's table "ATE performance", on real images.
const PAPER: (&str, &str) = ("closed_loop.csv", include_str!("../../papers/closed_loop.csv"));
/// VINS-Mono (C++, its own defaults) on the given tracks.
const VINS_MONO: (&str, &str) = ("vins_mono_tracks.csv", include_str!("../../papers/vins_mono_tracks.csv"));

/// Absolute errors of somebody else, by sequence and noise.
#[derive(Debug, Clone, PartialEq)]
pub struct Peer {
    /// Name in the table.
    pub name: &'static str,
    noises: Vec<String>,
    rows: Vec<(String, Vec<f64>)>,
}

impl Peer {
    /// The paper's own, noises `x0.5`, `x1`, `x2`, `dualpronet`.
    ///
    /// # Errors
    /// [`ClosedLoopError::Paper`].
    pub fn paper() -> Result<Self, ClosedLoopError> {
        Self::read("paper", PAPER)
    }

    /// VINS-Mono's, noises `x0.5` to `x16`.
    ///
    /// # Errors
    /// [`ClosedLoopError::Paper`].
    pub fn vins_mono() -> Result<Self, ClosedLoopError> {
        Self::read("vins", VINS_MONO)
    }

    /// Absolute error of one cell \[m\]; `sequence` with or without its difficulty.
    pub fn ate(&self, sequence: &str, noise: &str) -> Option<f64> {
        paper_side(sequence)?;
        let column = self.noises.iter().position(|n| n == noise)?;
        self.rows.iter().find(|(name, _)| sequence.starts_with(name.as_str())).map(|(_, ates)| ates[column])
    }

    /// Columns are those called `ate_NOISE_m`.
    fn read(name: &'static str, (file, text): (&'static str, &str)) -> Result<Self, ClosedLoopError> {
        let bad = |line: usize, text: &str| ClosedLoopError::Paper { file, line, text: text.to_owned() };
        let mut lines = (1..).zip(text.lines()).filter(|(_, text)| !text.trim().is_empty());
        let (_, header) = lines.next().ok_or_else(|| bad(1, ""))?;
        let noise = |column: &str| Some(column.strip_prefix("ate_")?.strip_suffix("_m")?.to_owned());
        let columns: Vec<(usize, String)> =
            header.split(',').enumerate().filter_map(|(i, column)| Some((i, noise(column)?))).collect();
        let rows = lines
            .map(|(line, text)| {
                let cells: Vec<&str> = text.split(',').collect();
                let of = |(i, _): &(usize, String)| cells.get(*i)?.parse::<f64>().ok();
                let ates: Option<Vec<f64>> = columns.iter().map(of).collect();
                ates.map(|ates| (cells[0].to_owned(), ates)).ok_or_else(|| bad(line, text))
            })
            .collect::<Result<_, _>>()?;
        Ok(Self { name, noises: columns.into_iter().map(|(_, noise)| noise).collect(), rows })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_built_in_tables_read_and_have_the_means_they_are_known_by() {
        let (paper, vins) = (Peer::paper().unwrap(), Peer::vins_mono().unwrap());
        let mean = |peer: &Peer, noise: &str| {
            let all: Vec<f64> = peer.rows.iter().map(|(name, _)| peer.ate(name, noise).unwrap()).collect();
            (all.iter().sum::<f64>() / all.len() as f64, all.len())
        };
        // As the paper's text and the comparison give them.
        for (peer, noise, known) in [
            (&paper, "x1", 0.196),
            (&paper, "dualpronet", 0.150),
            (&vins, "x1", 0.175),
            (&vins, "x16", 0.286),
        ] {
            let (mean, count) = mean(peer, noise);
            assert!((mean - known).abs() < 6e-4 && count == 11, "{noise}: {mean}");
        }
        assert_eq!(vins.ate("MH_02_easy", "x16"), Some(1.56));
        assert_eq!(paper.ate("MH_02", "x4"), None);
        assert_eq!(vins.ate("f01-hall-slow", "x1"), None);
    }

    #[test]
    fn a_broken_table_is_named_with_its_line() {
        let text = "sequence,ate_x1_m\nMH_01,0.1\nMH_02,none\n";
        let error = Peer::read("x", ("t.csv", text)).unwrap_err().to_string();
        assert_eq!(error, "papers/t.csv, line 3: `MH_02,none` does not read; mend it and build again");
    }
}
