//! What is run.

use super::specs::{BASELINE, DATA_SHEET, DUALPRONET, ORACLE};
use dpn_core::config::{ConfigFault, ConfigFaults, Validate};
use dpn_core::estimate::NoiseSpec;
use dpn_core::estimate::spec::EstimatorSpec;
use dpn_eval::injected::{Course, Injection};
use dpn_eval::study::MARGIN;
use dpn_train::base::Base;
use serde::{Deserialize, Serialize};

/// Everything that decides which numbers are made. Keys that do not stand in a file are those of [`Plan::whole`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Plan {
    /// Bases of the open loop: `sg(5,2)`, the nearest to the paper's, and others.
    pub bases: Vec<String>,
    /// First seed of everything; 0 to 1e9.
    pub seed: u64,
    /// Noises run with `seeds` seeds: the paper's columns, the sweep of constants, DualProNet and what is learned while it runs, with their controls.
    pub noises: Vec<String>,
    /// Seeds of tracks (and flights) for each of `noises`; 1 to 100.
    pub seeds: u64,
    /// Noises run with `other_seeds` seeds: the rest of the study.
    pub others: Vec<String>,
    /// Seeds for each of `others`; 1 to 100.
    pub other_seeds: u64,
    /// Half width of what counts as equal to the best constant, as a share of its error; above 0 and at most 1.
    pub margin: f64,
    /// The experiment with injected noise.
    pub injected: InjectedPlan,
}

dpn_core::settings!(
    /// The experiment with injected noise.
    pub struct InjectedPlan {
        /// What is added in the course `step`; the other courses have the same strengths.
        pub noise: Injection = Injection::default(),
        /// Courses through the closed loop; the responses to all of them are measured in any case.
        pub courses: Vec<Course> = Course::ADDING.to_vec(),
        /// Noises of the closed loop on `step`; a constant among them at least.
        pub noises: Vec<String> = specs(
            "x4 x8 x12 x16 x24 x32 oracle dualpronet plus(dualpronet(wide-s0),x4) mean(plus(dualpronet(wide-s0),x4)) \
             shuffled(plus(dualpronet(wide-s0),x4)) plus(diff2,x4) diff2 self",
        ),
        /// Noises of the closed loop on the other courses; those of them that are a noise of samples alone and no constants are also asked how they respond.
        pub followed: Vec<String> = specs("x2 x4 x8 x12 x16 oracle dualpronet self plus(dualpronet(wide-s0),x4) diff2"),
        /// Seeds on `step`; 1 to 100.
        pub seeds: u64 = 2,
        /// Seeds on the other courses; 1 to 100.
        pub course_seeds: u64 = 1,
        /// Sequences at most, in order; 0 for all.
        pub most_sequences: usize = 0,
    }
);

/// The specs of a list that are parted by spaces.
fn specs(text: &str) -> Vec<String> {
    text.split_whitespace().map(str::to_owned).collect()
}

impl Default for Plan {
    fn default() -> Self {
        Self::whole()
    }
}

impl Plan {
    /// The whole study.
    pub fn whole() -> Self {
        let noises = specs(
            "x0.5 x1 x2 x4 x8 dualpronet mean(dualpronet) shuffled(dualpronet) dualpronet(wide-s0) mean(dualpronet(wide-s0)) \
             shuffled(dualpronet(wide-s0)) self mean(self) shuffled(self)",
        );
        let mut others = specs("x0.25 x16");
        others.push(DATA_SHEET.to_owned());
        others.extend(specs(
            "mean-of-train(dualpronet) dualpronet(order-s0) dualpronet(total-s0) dualpronet(paper-s0) plus(dualpronet(wide-s0),x4)",
        ));
        others.extend(EstimatorSpec::all().iter().map(ToString::to_string));
        Self {
            bases: Base::STUDY.iter().map(ToString::to_string).collect(),
            seed: 1,
            noises,
            seeds: 2,
            others,
            other_seeds: 1,
            margin: MARGIN,
            injected: InjectedPlan::default(),
        }
    }

    /// A few minutes' worth, for the simulated flights: every table and figure, with fewer noises and one seed.
    pub fn quick() -> Self {
        Self {
            bases: specs("sg(5,2) sg(11,2)"),
            seed: 0,
            noises: specs("x0.5 x1 x2 x4 x8 dualpronet mean(dualpronet) shuffled(dualpronet) self"),
            seeds: 1,
            others: Vec::new(),
            other_seeds: 1,
            margin: MARGIN,
            injected: InjectedPlan {
                courses: vec![Course::Step],
                noises: specs("x4 x8 x16 x24 oracle dualpronet plus(dualpronet(wide-s0),x4) self"),
                followed: specs("oracle dualpronet plus(dualpronet(wide-s0),x4) diff2"),
                seeds: 1,
                most_sequences: 4,
                ..InjectedPlan::default()
            },
        }
    }

    /// The noises of a list, parsed.
    ///
    /// # Errors
    /// A string that is no spec.
    pub(super) fn parsed<'a>(
        specs: impl IntoIterator<Item = &'a String>,
    ) -> Result<Vec<NoiseSpec>, dpn_core::estimate::SpecError> {
        specs.into_iter().map(|spec| spec.parse()).collect()
    }
}

impl Validate for Plan {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = ConfigFaults::default();
        let injected = &self.injected;
        for fault in injected.noise.faults() {
            let key = format!("injected.noise.{}", fault.key);
            faults.0.push(ConfigFault { key, ..fault });
        }
        faults.within("seed", self.seed, 0, 1_000_000_000);
        for (key, seeds) in [
            ("seeds", self.seeds),
            ("other_seeds", self.other_seeds),
            ("injected.seeds", injected.seeds),
            ("injected.course_seeds", injected.course_seeds),
        ] {
            faults.within(key, seeds, 1, 100);
        }
        faults.check(self.margin > 0.0 && self.margin <= 1.0, "margin", self.margin, "above 0 and at most 1");
        for base in &self.bases {
            let good = base.parse::<Base>().is_ok_and(|base| base.filter().is_ok());
            faults.check(good, "bases", base, "bases such as \"sg(11,2)\", window odd and above the order");
        }
        faults.check(!self.bases.is_empty(), "bases", "[]", "one base or more");
        for (key, specs) in [
            ("noises", &self.noises),
            ("others", &self.others),
            ("injected.noises", &injected.noises),
            ("injected.followed", &injected.followed),
        ] {
            for spec in specs {
                if let Err(error) = spec.parse::<NoiseSpec>() {
                    faults.check(false, key, spec, format!("a noise spec ({error})"));
                }
            }
        }
        let constant =
            |specs: &[String]| specs.iter().any(|s| s.parse::<NoiseSpec>().is_ok_and(|n| n.is_constant()));
        for needed in [BASELINE, DUALPRONET] {
            let there = self.noises.iter().any(|spec| spec == needed);
            faults.check(there, "noises", format!("{:?}", self.noises), format!("with {needed}"));
        }
        for (key, specs) in [("injected.noises", &injected.noises), ("injected.followed", &injected.followed)]
        {
            let needs = key == "injected.noises";
            faults.check(!needs || constant(specs), key, format!("{specs:?}"), "with a constant");
            let oracle = specs.iter().any(|spec| spec == ORACLE);
            faults.check(oracle, key, format!("{specs:?}"), "with oracle");
        }
        faults.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn both_plans_are_sound_and_the_written_one_is_the_whole_one() {
        Plan::whole().validate().unwrap();
        Plan::quick().validate().unwrap();
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/paper/whole.toml");
        assert_eq!(dpn_io::config::load::<Plan>(&path).unwrap(), Plan::whole());
        let figures = dpn_io::config::load::<Plan>(&path.with_file_name("figures.toml")).unwrap();
        assert_eq!(figures, Plan { other_seeds: 2, ..Plan::whole() });
    }

    #[test]
    fn faults_are_named_all_at_once() {
        let text = "seeds = 0\nmargin = 2.0\nbases = [\"sg(4,2)\"]\nnoises = [\"x1\", \"dualpronett\"]";
        let error = dpn_io::config::parse::<Plan>(text, Path::new("p.toml")).unwrap_err().to_string();
        for words in
            ["`seeds` is 0", "`margin` is 2", "sg(4,2)", "did you mean `dualpronet`?", "with dualpronet"]
        {
            assert!(error.contains(words), "{words}: {error}");
        }
    }
}
