//! Rows of the open loop, the paper's figures beside them: all of them, and the paper's table.
//!
//! The paper gives one RMSE a sensor and split, without its filter; what it shows is nearest to base SG(5,2) on its own grid with
//! label `sigma_inj`, so its row stands under those rows alone, marked `paper`, with every cell empty that it does not fill.

use super::super::input::Input;
use super::super::specs::estimator_name;
use dpn_core::Sensor;
use dpn_core::estimate::spec::EstimatorSpec;
use dpn_eval::open_loop::Row;
use dpn_eval::published;
use dpn_figures::{Cell, Column, Provenance, Table};
use dpn_train::label::Label;
use dpn_train::split::Side;

/// All `rows` in their order; a line of the paper follows the last row it belongs to.
pub fn open_loop_rows(rows: &[Row]) -> Table {
    let words = ["sensor", "data", "base", "split", "levels", "label", "estimator"];
    let numbers = ["rmse", "rmse_spread", "bias", "crb", "ratio", "n", "seeds", "out of range"];
    let mut table = Table::new("open_loop", "", Column::all(&words, &numbers));
    for (i, row) in rows.iter().enumerate() {
        // As many decimals as hold three digits or more of the sensor's errors; the same in all rows, so that points align.
        let decimals = if row.sensor == Sensor::Accel { 5 } else { 6 };
        let figure = |value: Option<f64>| Cell::number(value, decimals);
        let (split, label) = (row.split.to_string(), row.label.to_string());
        let words = [row.sensor.name(), &row.data, &row.base, &split, &row.levels, &label, &row.estimator];
        let mut cells = words.map(Cell::text).to_vec();
        cells.extend([Some(row.rmse), row.rmse_spread, Some(row.bias), Some(row.crb)].map(figure));
        cells.extend([Cell::number(row.ratio, 2), Cell::text(row.n), Cell::text(row.seeds)]);
        cells.push(Cell::percent(row.outside, 0));
        table.row(cells);
        let is_papers = row.base == "sg(5,2)" && row.levels == "grid" && row.label == Label::Injected;
        if is_papers && !rows[i + 1..].iter().any(|later| same_windows(row, later)) {
            let rmse = published::network_rmse(row.sensor).of(row.split);
            let words = [row.sensor.name(), "euroc", "", &split, &row.levels, "", "paper"];
            let word = |word: &str| if word.is_empty() { Cell::none() } else { Cell::text(word) };
            let mut cells = words.map(word).to_vec();
            cells.push(Cell::text(rmse));
            cells.resize(table.columns.len(), Cell::none());
            table.row(cells);
        }
    }
    table
}

/// Whether two rows differ in nothing but the estimator.
fn same_windows(a: &Row, b: &Row) -> bool {
    let windows = |row: &Row| {
        (row.sensor, row.base.clone(), row.data.clone(), row.split, row.levels.clone(), row.label)
    };
    windows(a) == windows(b)
}

/// A line a sensor, base and kind of estimator: networks, the best simple estimator, the best regressor.
pub(crate) fn open_loop(input: &Input, rows: &[Row], made_by: Provenance) -> Table {
    let words = ["estimator", "sensor"];
    let numbers = [
        "test RMSE",
        "RMSE / bound",
        "bound",
        "train RMSE",
        "spread over seeds",
        "bias",
        "windows",
        "training seeds",
    ];
    let title =
        format!("RMSE of the estimated deviation of injected noise, {} windows, label sigma_inj", input.name);
    let mut columns = Column::all(&words, &numbers);
    columns.splice(2..2, ["base", "levels"].map(Column::text));
    let mut table = Table::new("open_loop", title, columns).made_by(made_by);
    // A row may carry the estimator's parameters where the spec leaves them to a default.
    let stem = |name: &str| name.split('(').next().unwrap_or(name).to_owned();
    let simple: Vec<String> = EstimatorSpec::all().iter().map(|spec| stem(&spec.to_string())).collect();
    for sensor in Sensor::ALL {
        let digits = if sensor == Sensor::Accel { 4 } else { 5 };
        let paper = published::network_rmse(sensor);
        let words = ["the paper (EuRoC)", sensor.name(), "not given", "grid"];
        let mut cells = words.map(Cell::text).to_vec();
        let [test, train] = [paper.test_rmse, paper.train_rmse].map(|rmse| Cell::number(rmse, digits));
        cells.extend([test, Cell::none(), Cell::none(), train]);
        cells.resize(table.columns.len(), Cell::none());
        table.row(cells);
        let wanted = |row: &&Row| {
            row.sensor == sensor
                && row.label == Label::Injected
                && row.base != "raw"
                && row.data == input.corpus.name
        };
        let of_sensor: Vec<&Row> = rows.iter().filter(wanted).collect();
        let mut groups: Vec<(&str, &str, &str)> = Vec::new();
        for row in &of_sensor {
            let group = (row.data.as_str(), row.base.as_str(), row.levels.as_str());
            if !groups.contains(&group) {
                groups.push(group);
            }
        }
        for (data, base, levels) in groups {
            let group: Vec<&Row> = of_sensor
                .iter()
                .copied()
                .filter(|r| r.data == data && r.base == base && r.levels == levels)
                .collect();
            let side = if group.iter().any(|r| r.split == Side::Test) { Side::Test } else { Side::Train };
            let test = || group.iter().copied().filter(|r| r.split == side);
            if !test().any(|row| row.seeds > 0) {
                continue; // nothing was trained for this base and kind of levels
            }
            let best = |names: &dyn Fn(&str) -> bool| {
                test()
                    .filter(|r| r.seeds == 0 && names(&r.estimator))
                    .min_by(|a, b| a.rmse.total_cmp(&b.rmse))
            };
            let is_simple = |name: &str| simple.contains(&stem(name));
            let is_regressor = |name: &str| !is_simple(name);
            let mut shown: Vec<&Row> = test().filter(|row| row.seeds > 0).collect();
            shown.extend(best(&is_simple));
            shown.extend(best(&is_regressor));
            for row in shown {
                let judged = (side == Side::Test).then_some(row);
                let train = group.iter().find(|r| r.split == Side::Train && r.estimator == row.estimator);
                let kind = if row.seeds > 0 {
                    ""
                } else if is_simple(&row.estimator) {
                    "best simple: "
                } else {
                    "best regressor: "
                };
                table.row(vec![
                    Cell::named(format!("{kind}{}", estimator_name(&row.estimator)), &row.estimator),
                    Cell::text(sensor.name()),
                    Cell::text(base),
                    Cell::text(levels),
                    Cell::number(judged.map(|r| r.rmse), digits),
                    Cell::number(row.ratio, 2),
                    Cell::number(row.crb, digits),
                    Cell::number(train.map(|r| r.rmse), digits),
                    Cell::number(row.rmse_spread, digits + 1),
                    Cell::number(row.bias, digits),
                    Cell::text(row.n),
                    Cell::text(row.seeds),
                ]);
            }
        }
        if sensor == Sensor::Accel {
            table.rule();
        }
    }
    table.note("Accelerometer in m/s^2, gyroscope in rad/s. Base: the signal that noise was injected into. Bound: Cramer-Rao, of unbiased \
                estimates from windows of white noise alone; prior knowledge of the levels may go below it.");
    table.note("Spread, bias, ratio and windows are those of the test windows; of the training windows where there is no test sequence.");
    table.note("The paper does not say its base; nearest to its figures is sg(5,2) on its grid.");
    if !input.is_papers() {
        table.note("These windows are not the paper's: its row stands there for the order of magnitude.");
    }
    table.notes(input.notes());
    table
}
