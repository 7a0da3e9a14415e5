//! Noises against one constant as a strip each: the ratio of errors with its interval, on one logarithmic scale. Drawn by the page itself, so
//! that names stay text and no letter is smaller than the page's.

use super::specs;
use dpn_core::estimate::NoiseSpec;
use dpn_eval::study::{Comparison, Study};

/// Ratios that may be marked, on a narrow scale and on a wide one.
const FINE: [f64; 7] = [0.5, 0.65, 0.8, 1.0, 1.25, 1.5, 2.0];
const COARSE: [f64; 7] = [0.1, 0.25, 0.5, 1.0, 2.0, 4.0, 10.0];
/// Logarithm of highest over lowest ratio of a narrow scale.
const NARROW: f64 = 1.5;

/// All strips.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Forest {
    /// What the ratios are to.
    pub(super) reference: String,
    pub(super) strips: Vec<Strip>,
    /// Words of the scale's marks and where they stand \[%\].
    pub(super) ticks: Vec<(String, f64)>,
    /// Where the reference stands \[%\].
    pub(super) one: f64,
}

/// One noise.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Strip {
    pub(super) name: String,
    pub(super) spec: String,
    /// `constant`, `network`, `learned`, `control` or `simple`.
    pub(super) kind: &'static str,
    /// Whether the test shows a difference.
    pub(super) shown: bool,
    /// Ratio and its interval in words, and in how many sequences it is better.
    pub(super) words: String,
    pub(super) better: String,
    /// Where ratio and ends of its interval stand \[%\].
    pub(super) at: f64,
    pub(super) from: f64,
    pub(super) width: f64,
}

impl Forest {
    /// The study's noises against the constant that they are compared with: those that decide the question.
    pub(super) fn of_study(study: &Study) -> Option<Self> {
        let shown = specs::SHOWN.map(specs::noise);
        let lines = shown.iter().filter_map(|noise| study.of(noise));
        let compared = lines.filter_map(|line| Some((&line.noise, line.comparison.as_ref()?)));
        Self::new(&study.reference.as_ref()?.noise, compared)
    }

    /// The same where noise was added: all of them, constants last.
    pub(super) fn of_course(study: &Study) -> Option<Self> {
        let all = study.noises.iter().filter_map(|line| Some((&line.noise, line.comparison.as_ref()?)));
        let (constants, others): (Vec<_>, Vec<_>) = all.partition(|(noise, _)| noise.is_constant());
        Self::new(&study.reference.as_ref()?.noise, others.into_iter().chain(constants))
    }

    /// Of the noises that were compared; nothing where none was.
    fn new<'a>(
        reference: &NoiseSpec,
        compared: impl Iterator<Item = (&'a NoiseSpec, &'a Comparison)>,
    ) -> Option<Self> {
        let compared: Vec<_> =
            compared.filter(|(_, c)| c.ratio_interval.iter().all(|end| *end > 0.0)).collect();
        let ends = || compared.iter().flat_map(|(_, c)| c.ratio_interval).chain([1.0]);
        // A strip's end and the reference stand inside the scale.
        let low = ends().fold(f64::INFINITY, f64::min).ln() - 0.05;
        let high = ends().fold(0.0, f64::max).ln() + 0.05;
        let at = |ratio: f64| 100.0 * (ratio.ln() - low) / (high - low);
        let strip = |(noise, c): &(&NoiseSpec, &Comparison)| {
            let [from, to] = c.ratio_interval;
            Strip {
                name: specs::name(noise),
                spec: noise.to_string(),
                kind: kind(noise),
                shown: c.p_holm.is_some_and(|p| p < 0.05),
                words: format!("{:.2} ({from:.2} to {to:.2})", c.ratio),
                better: format!("smaller in {} of {}", c.better, c.sequences),
                at: at(c.ratio),
                from: at(from),
                width: at(to) - at(from),
            }
        };
        let strips: Vec<Strip> = compared.iter().map(strip).collect();
        let inside = if high - low < NARROW { FINE } else { COARSE }
            .into_iter()
            .map(|tick| (format!("{tick}"), at(tick)));
        let ticks = inside.filter(|(_, at)| (2.0..=98.0).contains(at)).collect();
        (!strips.is_empty()).then(|| Self { reference: specs::name(reference), strips, ticks, one: at(1.0) })
    }
}

impl Forest {
    /// Whether a strip is of this kind.
    pub(super) fn has(&self, kind: impl AsRef<str>) -> bool {
        self.strips.iter().any(|strip| strip.kind == kind.as_ref())
    }
}

fn kind(noise: &NoiseSpec) -> &'static str {
    match noise {
        _ if noise.is_constant() => "constant",
        _ if noise.is_learned() => "learned",
        _ if specs::is_network(noise) => "network",
        _ if specs::is_control(noise) => "control",
        _ => "simple",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_stand_on_one_scale_inside_the_picture() {
        let of = |ratio: f64, low: f64, high: f64| Comparison {
            sequences: 11,
            better: 5,
            ratio,
            ratio_interval: [low, high],
            p: Some(0.4),
            p_holm: Some(0.01),
            p_equal: None,
        };
        let [x2, x1, dualpronet] = specs::noises(["x2", "x1", "dualpronet"]);
        let (a, b) = (of(1.24, 1.11, 1.38), of(1.01, 0.87, 1.16));
        let forest = Forest::new(&x2, [(&x1, &a), (&dualpronet, &b)].into_iter()).unwrap();
        let [first, second] = &forest.strips[..] else { panic!("{forest:?}") };
        assert_eq!((first.kind, second.kind), ("constant", "network"));
        assert_eq!(second.words, "1.01 (0.87 to 1.16)");
        assert!(second.from > 0.0 && first.from + first.width < 100.0);
        assert!(second.from < forest.one && forest.one < second.at && second.at < first.at);
        assert_eq!(forest.ticks.iter().map(|tick| tick.0.as_str()).collect::<Vec<_>>(), ["1", "1.25"]);
        assert_eq!(Forest::new(&x2, std::iter::empty()), None);
    }
}
