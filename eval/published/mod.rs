//! What others published: the paper's tables, and VINS-Mono measured on the given tracks. Read here and nowhere else.
//!
//! The files are those beside this one, built into the program, so that one that does not read is a mistake of whoever edited it: a test
//! reads all of them, and the readers panic.
//!
//! # Source
//! Solodar and Klein, VIO-DualProNet: the split and its minutes, "RMSE of the inertial uncertainty", "ATE performance".

mod ate;

pub use ate::PublishedAte;

use dpn_core::Sensor;
use dpn_train::split::{Side, paper_side};
use serde::Deserialize;
use serde::de::DeserializeOwned;

/// A sequence of the paper's split.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct SplitSequence {
    /// Short name, `MH_01`.
    pub sequence: String,
    /// Its side.
    pub side: Side,
    /// Rows of its IMU file.
    pub imu_rows: usize,
}

/// RMSE of the paper's network of one sensor \[unit of the sensor\].
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct NetworkRmse {
    /// The sensor.
    pub sensor: Sensor,
    /// On the training windows.
    pub train_rmse: f64,
    /// On the test windows.
    pub test_rmse: f64,
}

impl NetworkRmse {
    /// On the windows of one side.
    pub fn of(&self, side: Side) -> f64 {
        match side {
            Side::Train => self.train_rmse,
            Side::Test => self.test_rmse,
        }
    }
}

/// The eleven sequences, in the paper's order.
pub fn split() -> Vec<SplitSequence> {
    rows(include_str!("split.csv"))
}

/// Minutes as the paper prints them: training, test, all.
pub fn printed_minutes() -> [f64; 3] {
    #[derive(Deserialize)]
    struct Minutes {
        side: String,
        printed_min: f64,
    }
    let all: Vec<Minutes> = rows(include_str!("minutes.csv"));
    ["train", "test", "total"].map(|side| {
        all.iter()
            .find(|row| row.side == side)
            .expect("minutes.csv has both sides and their total")
            .printed_min
    })
}

/// RMSE of the paper's network of a sensor.
pub fn network_rmse(sensor: Sensor) -> NetworkRmse {
    let all: Vec<NetworkRmse> = rows(include_str!("open_loop.csv"));
    all.into_iter().find(|row| row.sensor == sensor).expect("open_loop.csv has both sensors")
}

/// Rate of improvement over the baseline as the paper prints it \[%\]; `sequence` with or without its difficulty.
pub fn printed_improvement(sequence: &str) -> Option<f64> {
    #[derive(Deserialize)]
    struct Improvement {
        sequence: String,
        improvement_printed_percent: f64,
    }
    paper_side(sequence)?;
    let all: Vec<Improvement> = rows(include_str!("closed_loop.csv"));
    let row = all.into_iter().find(|row| sequence.starts_with(&row.sequence))?;
    Some(row.improvement_printed_percent)
}

fn rows<T: DeserializeOwned>(text: &str) -> Vec<T> {
    let rows = csv::Reader::from_reader(text.as_bytes()).into_deserialize().collect::<Result<_, _>>();
    rows.expect("the tables are built in, and a test reads them all")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_papers_figures_are_as_printed() {
        let all = split();
        assert_eq!((all.len(), all[0].imu_rows), (11, 36820));
        assert_eq!(all.iter().filter(|s| s.side == Side::Train).count(), 6);
        assert!(all.iter().all(|s| paper_side(&s.sequence) == Some(s.side)));
        assert_eq!(printed_minutes(), [12.5, 12.0, 22.5]);
        let gyro = network_rmse(Sensor::Gyro);
        assert_eq!([Side::Train, Side::Test].map(|side| gyro.of(side)), [0.00162, 0.00185]);
        assert_eq!(network_rmse(Sensor::Accel).test_rmse, 0.0301);
        assert_eq!(printed_improvement("MH_02_easy"), Some(-11.7));
        assert_eq!(printed_improvement("f01-hall-slow"), None);
    }
}
