//! Open-loop RMSE, the paper's figures beside ours.

use super::super::command::Provenance;
use super::super::error::PaperError;
use super::super::input::Input;
use super::super::published;
use super::super::table::{Cell, Table};
use dpn_core::Sensor;
use dpn_core::estimate::spec::EstimatorSpec;
use dpn_eval::open_loop::Row;

/// A line a sensor, base and kind of estimator: networks, the best simple estimator, the best regressor.
pub(crate) fn open_loop(input: &Input, rows: &[Row], made_by: Provenance) -> Result<Table, PaperError> {
    let heads = [
        "sensor",
        "base",
        "levels",
        "estimator",
        "=train RMSE",
        "=test RMSE",
        "=spread over seeds",
        "=bias",
        "=bound",
        "=RMSE / bound",
        "=windows",
        "=training seeds",
    ];
    let title =
        format!("RMSE of the estimated deviation of injected noise, {} windows, label sigma_inj", input.name);
    let mut table = Table::new("open_loop", title, &heads, made_by);
    // A row may carry the estimator's parameters where the spec leaves them to a default.
    let stem = |name: &str| name.split('(').next().unwrap_or(name).to_owned();
    let simple: Vec<String> = EstimatorSpec::all().iter().map(|spec| stem(&spec.to_string())).collect();
    for sensor in Sensor::ALL {
        let digits = if sensor == Sensor::Accel { 4 } else { 5 };
        if let Some([train, test]) = published::rmse(sensor)? {
            let mut cells = vec![Cell::text(sensor.name()), Cell::text("not given"), Cell::text("grid")];
            cells.extend([
                Cell::text("the paper (EuRoC)"),
                Cell::number(train, digits),
                Cell::number(test, digits),
            ]);
            cells.extend(std::iter::repeat_n(Cell::number(None, 0), 6));
            table.row(cells);
        }
        let wanted = |row: &&Row| {
            row.sensor == sensor
                && row.label == "sigma_inj"
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
            let side = if group.iter().any(|r| r.split == "test") { "test" } else { "train" };
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
                let judged = (side == "test").then_some(row);
                let train = group.iter().find(|r| r.split == "train" && r.estimator == row.estimator);
                let kind = if row.seeds > 0 {
                    row.estimator.clone()
                } else if is_simple(&row.estimator) {
                    format!("best simple: {}", row.estimator)
                } else {
                    format!("best regressor: {}", row.estimator)
                };
                table.row(vec![
                    Cell::text(sensor.name()),
                    Cell::text(base),
                    Cell::text(levels),
                    Cell::text(kind),
                    Cell::number(train.map(|r| r.rmse), digits),
                    Cell::number(judged.map(|r| r.rmse), digits),
                    Cell::number(row.rmse_spread, digits + 1),
                    Cell::number(row.bias, digits),
                    Cell::number(row.crb, digits),
                    Cell::number(row.ratio, 2),
                    Cell::count(row.n),
                    Cell::count(row.seeds),
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
    for note in input.notes() {
        table.note(note);
    }
    Ok(table)
}
