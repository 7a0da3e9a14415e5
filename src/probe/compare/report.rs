//! What has changed, for people.

use super::{BandChange, BiasChange, Comparison, Level};
use crate::doctor::vibration::Shaking;
use crate::text::aligned;
use dpn_core::noise::Interval;
use std::fmt::Write;

impl Comparison {
    /// The page; `names` are those of the logs.
    pub fn page(&self, names: [&str; 2]) -> String {
        let mut rows = vec![["", "log", "Hz", "s", "rest s", "lost"].map(str::to_owned)];
        for (i, name) in names.into_iter().enumerate() {
            rows.push([
                ["A", "B"][i].to_owned(),
                name.to_owned(),
                format!("{:.1}", self.rate_hz[i]),
                format!("{:.0}", self.length_s[i]),
                format!("{:.0}", self.rest_s[i]),
                format!("{:.2} %", 100.0 * self.lost[i]),
            ]);
        }
        let mut text = aligned(&rows);
        for remark in &self.remarks {
            let _ = writeln!(text, "note: {remark}");
        }
        if !self.levels.is_empty() {
            let mut rows =
                vec![["white noise, B / A (95 %)", "x", "y", "z", "together", ""].map(str::to_owned)];
            rows.extend(self.levels.iter().map(level));
            text.push_str(&aligned(&rows));
        }
        if !self.bias.is_empty() {
            let mut rows = vec![["at rest", "A", "B", "change (95 %)", ""].map(str::to_owned)];
            rows.extend(self.bias.iter().map(bias));
            text.push_str(&aligned(&rows));
        }
        if !self.bands.is_empty() {
            let mut rows = vec![["shakes", "A", "B", "B / A"].map(str::to_owned)];
            rows.extend(self.bands.iter().map(band));
            text.push_str(&aligned(&rows));
        }
        for (name, findings) in ["A", "B"].into_iter().zip(&self.findings) {
            for finding in findings {
                let _ =
                    writeln!(text, "only {name}: {}: {}: {}", finding.weight, finding.about, finding.text);
            }
        }
        text
    }
}

fn level(of: &Level) -> [String; 6] {
    let ratio = |Interval { value, low, high }: Interval| format!("{value:.2} ({low:.2} to {high:.2})");
    let [x, y, z] = of.ratios.map(ratio);
    let verdict = match of.ratio {
        Interval { low, .. } if low > 1.0 => "louder",
        Interval { high, .. } if high < 1.0 => "quieter",
        _ => "no change seen",
    };
    // In motion it is the vehicle's as much as the sensor's.
    let of_what = if of.when == "at rest" { "" } else { ", vibration included" };
    [format!("  {} {}", of.sensor, of.when), x, y, z, ratio(of.ratio), format!("{verdict}{of_what}")]
}

fn bias(of: &BiasChange) -> [String; 5] {
    let [a, b] = of.values.map(|value| format!("{value:.5}"));
    let [change, low, high] = of.change;
    let seen = if low > 0.0 || high < 0.0 { "" } else { "no change seen" };
    [
        format!("  {} [{}]", of.of, of.unit),
        a,
        b,
        format!("{change:.5} ({low:.5} to {high:.5})"),
        seen.to_owned(),
    ]
}

fn band(of: &BandChange) -> [String; 4] {
    let word = |band: &Option<Shaking>| match band {
        Some(band) => format!("{:.1} Hz, {:.3} {} rms", band.hz, band.rms, of.sensor.unit()),
        None => "-".to_owned(),
    };
    let ratio = match of.bands {
        [Some(a), Some(b)] => format!("{:.2}", b.rms / a.rms),
        [Some(_), None] => "gone".to_owned(),
        _ => "new".to_owned(),
    };
    [format!("  {} {}", of.sensor, of.axis), word(&of.bands[0]), word(&of.bands[1]), ratio]
}
