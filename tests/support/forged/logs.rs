//! Logs as text: stamps that cannot be, values that cannot be, shapes that are none.

use super::Forged;

/// A CSV log of `count` rows by stamp and value.
fn rows(count: usize, t: impl Fn(usize) -> i64, v: impl Fn(usize) -> String) -> Vec<u8> {
    let mut text = String::from("t_ns,gx,gy,gz,ax,ay,az\n");
    for i in 0..count {
        text.push_str(&format!("{},{}\n", t(i), v(i)));
    }
    text.into_bytes()
}

/// Values at rest under some noise, the same each time.
fn still(i: usize) -> String {
    let noise = |k: usize| {
        (i.wrapping_mul(2_654_435_761).wrapping_add(k * 40_503) >> 7) as f64 % 1000.0 / 1000.0 - 0.5
    };
    let n: [f64; 6] = std::array::from_fn(noise);
    format!(
        "{:.5},{:.5},{:.5},{:.4},{:.4},{:.4}",
        0.004 * n[0],
        0.004 * n[1],
        0.004 * n[2],
        0.1 * n[3],
        0.1 * n[4],
        9.81 + 0.1 * n[5]
    )
}

/// All of them.
pub fn logs() -> Vec<Forged> {
    const STEP: i64 = 5_000_000;
    let mut all = Vec::new();
    // What a wrong unit of time makes of a log: the rate says nothing of how much there is.
    for (name, count, step) in [
        ("100 rows 1 ns apart", 100, 1),
        ("50,000 rows 1 ns apart", 50_000, 1),
        ("50,000 rows 1 us apart", 50_000, 1000),
        ("100,000 rows at 32 kHz", 100_000, 31_250),
        ("50,000 rows at 4 kHz", 50_000, 250_000),
        ("20,000 rows at 200 Hz", 20_000, STEP),
        ("2000 rows a minute apart", 2000, 60_000_000_000),
        ("200 rows a year apart", 200, 31_557_600_000_000_000),
    ] {
        all.push(Forged::new(name, move || rows(count, |i| i as i64 * step, still)));
    }
    let mut log = |name: &str, make: fn() -> Vec<u8>| all.push(Forged::new(name, make));
    log("stamps that repeat", || rows(50_000, |_| 5, still));
    log("stamps that go back", || rows(50_000, |i| -(i as i64), still));
    log("a first stamp of 976", || {
        rows(5000, |i| if i == 0 { 976 } else { 1_403_715_285_000_000_000 + i as i64 * STEP }, still)
    });
    log("stamps at both ends of time", || {
        rows(5000, |i| if i < 2500 { i64::MIN + i as i64 } else { i64::MAX - 5000 + i as i64 }, still)
    });
    log("a dead sensor", || rows(5000, |i| i as i64 * STEP, |_| "0,0,0,0,0,9.81".to_owned()));
    // Shapes.
    log("nothing", Vec::new);
    log("a line's end", || b"\n".to_vec());
    log("a mark of order", || b"\xef\xbb\xbf".to_vec());
    log("zeros", || vec![0; 1 << 20]);
    log("line ends", || vec![b'\n'; 4 << 20]);
    log("one column", || b"1\n".repeat(1 << 20));
    log("a line of delimiters", || vec![b','; 8 << 20]);
    log("a line of blanks and digits", || b"1 ".repeat(4 << 20));
    log("a line of digits", || vec![b'7'; 8 << 20]);
    log("a header of a million names", || [b"t,".repeat(1 << 20), b"\n1,2\n".to_vec()].concat());
    log("a million comments", || b"#t,x\n".repeat(1 << 20));
    log("quotes", || b"\"\",".repeat(1 << 20));
    for value in ["1e308", "1e30", "1e-300", "5e-324", "nan", "0", "16384", "1e11"] {
        let plain = [value; 6].join(",");
        let turned = format!("-{}", [value; 6].join(",-"));
        let made = |name: String, v: Box<dyn Fn(usize) -> String + Send + Sync>| {
            // Ten seconds: most of these are honest logs, which the open loop takes its time to fit.
            Forged::new(name, move || rows(2000, |i| i as i64 * STEP, &v))
        };
        let all_of_it = plain.clone();
        all.push(made(format!("nothing but {value}"), Box::new(move |_| all_of_it.clone())));
        let once = plain.clone();
        let one = move |i| if i == 1000 { once.clone() } else { still(i) };
        all.push(made(format!("one sample of {value}"), Box::new(one)));
        let turns = move |i: usize| if i.is_multiple_of(2) { plain.clone() } else { turned.clone() };
        all.push(made(format!("{value} by turns"), Box::new(turns)));
    }
    all
}

/// Logs of tens of megabytes.
pub fn large_logs() -> Vec<Forged> {
    let mut all = Vec::new();
    let mut log = |name: &str, make: fn() -> Vec<u8>| all.push(Forged::new(name, make));
    log("50 MB of a log at 200 Hz", || rows(850_000, |i| i as i64 * 5_000_000, still));
    log("50 MB of rows 1 ns apart", || rows(1_050_000, |i| i as i64, still));
    log("50 MB of rows that are none", || b"a,b,c,d,e,f,g\n".repeat(3_600_000));
    log("50 MB of one line", || b"1,".repeat(25 << 20));
    log("50 MB of zeros", || vec![0; 50 << 20]);
    log("50 MB of short rows", || b"1\n".repeat(25 << 20));
    all
}
