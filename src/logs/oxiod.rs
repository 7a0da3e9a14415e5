//! OxIOD's tables of an iPhone's motion: no header, a stamp in seconds, then attitude, rotation rate \[rad/s\], gravity and user acceleration \[g\] and
//! magnetic field, three columns each. The accelerometer reads gravity and user acceleration together. Source: deepio.cs.ox.ac.uk, "OxIOD", README.

/// What is taken for granted.
pub(crate) const WORDS: &str = "OxIOD's columns: the accelerometer is gravity (columns 8 to 10) and user acceleration (11 to 13) together";
/// Columns.
const WIDTH: usize = 16;
/// Rows that are looked at.
const ROWS: usize = 50;

fn numbers(line: &str) -> Option<[f64; WIDTH]> {
    let row: Option<Vec<f64>> = line.split(',').map(|field| field.trim().parse().ok()).collect();
    row?.try_into().ok()
}

/// Whether a file begins with such rows: the eighth to tenth column are a unit vector.
pub(crate) fn is(head: &[u8]) -> bool {
    let text = String::from_utf8_lossy(head);
    let mut rows = text.lines().take(ROWS);
    let is_one = |line: &str| {
        numbers(line)
            .is_some_and(|row| (row[7..10].iter().map(|v| v * v).sum::<f64>().sqrt() - 1.0).abs() < 1e-3)
    };
    // The last may be cut off.
    rows.next().is_some_and(is_one) && rows.all(|line| is_one(line) || text.lines().next_back() == Some(line))
}

/// The rows under a header, the accelerometer whole.
pub(crate) fn table(text: &str) -> String {
    let mut table =
        "time [s],rotation_rate_x [rad/s],rotation_rate_y [rad/s],rotation_rate_z [rad/s],".to_owned();
    table.push_str(
        "accelerometerAccelerationX(G),accelerometerAccelerationY(G),accelerometerAccelerationZ(G)\n",
    );
    for line in text.lines() {
        // What is no such row is the table's reader's to refuse.
        let row = numbers(line).map(|row| {
            let [x, y, z] = [0, 1, 2].map(|axis| row[7 + axis] + row[10 + axis]);
            format!(
                "{},{},{},{},{x},{y},{z}",
                line.split(',').next().unwrap_or_default(),
                row[4],
                row[5],
                row[6]
            )
        });
        table.push_str(row.as_deref().unwrap_or(line));
        table.push('\n');
    }
    table
}
