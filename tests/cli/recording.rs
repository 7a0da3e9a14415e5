//! Made-up recordings as ASL folders: a still, level IMU with uniform noise, and one fault where asked for.

use std::fmt::Write;
use std::path::{Path, PathBuf};

/// Rows of data, each a stamp \[ns\] and six values: gyro, then accelerometer.
pub(crate) type Rows = Vec<(i64, [f64; 6])>;

/// EuRoC's header.
pub(crate) const HEADER: &str = "#timestamp [ns],w_RS_S_x [rad s^-1],w_RS_S_y [rad s^-1],w_RS_S_z [rad s^-1],\
    a_RS_S_x [m s^-2],a_RS_S_y [m s^-2],a_RS_S_z [m s^-2]";

/// `count` samples, `step_ns` apart. Noise by Knuth's linear congruential generator, so that no crate's version moves it.
pub(crate) fn rows(count: usize, step_ns: i64) -> Rows {
    let mut state = 20_210_827_u64;
    let mut noise = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
    };
    let sample = |i: usize| {
        let gyro: [f64; 3] = std::array::from_fn(|_| 0.004 * noise());
        let accel: [f64; 3] = std::array::from_fn(|_| 0.05 * noise());
        let t = 1_400_000_000_000_000_000 + i as i64 * step_ns;
        (t, [gyro[0], gyro[1], gyro[2], accel[0], accel[1], 9.81 + accel[2]])
    };
    (0..count).map(sample).collect()
}

/// The text of an ASL IMU file; sample `i` stands in line `i + 2`.
pub(crate) fn text(rows: &Rows) -> String {
    let mut text = format!("{HEADER}\n");
    for (t, [gx, gy, gz, ax, ay, az]) in rows {
        writeln!(text, "{t},{gx},{gy},{gz},{ax},{ay},{az}").unwrap();
    }
    text
}

/// Writes `text` as the IMU file of the sequence `name` in `dir`; returns `dir`.
pub(crate) fn put(dir: &Path, name: &str, text: &str) -> PathBuf {
    let imu = dir.join(name).join("mav0/imu0");
    std::fs::create_dir_all(&imu).unwrap();
    std::fs::write(imu.join("data.csv"), text).unwrap();
    dir.to_owned()
}

/// A folder `log` in `dir` with one sequence of 15 s at 200 Hz.
pub(crate) fn sound(dir: &Path) -> PathBuf {
    put(&dir.join("log"), "still", &text(&rows(3000, 5_000_000)))
}
