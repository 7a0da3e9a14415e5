//! All that is known of the noise along a log, as the command line and the page in the browser both say it.

use super::compare::{Check, compare};
use super::track::track_watched;
use super::{EffectiveNoise, Levels, LogNoiseError, Plan, Track, TrackSummary, report};
use crate::doctor::timing::batched;
use crate::phases::phases;
use crate::rates;
use crate::rest_noise::RestNoise;
use dpn_core::Recorded;
use dpn_io::noise_formats::NoiseCalibration;
use serde_json::Value;

/// The noise along a log.
#[derive(Debug)]
pub struct Along {
    /// Answer by answer.
    pub track: Track,
    /// Quantiles by phase.
    pub summary: TrackSummary,
    /// What must be said before everything else.
    pub warnings: Vec<String>,
    /// Densities at rest by the spectrum; none where the log does not rest for ten seconds.
    pub rest: Option<RestNoise>,
    /// The white noise that errs as much over a span; none where the log never moves.
    pub effective: Option<EffectiveNoise>,
    /// A configuration against it, where one was given and the log has levels to hold it against.
    pub check: Option<Check>,
}

impl Along {
    /// Asks `plan` along `recording` and holds `config` against it.
    ///
    /// # Errors
    /// A recording not longer than the first window; as [`track`](super::track()).
    pub fn of(
        plan: &Plan<'_>,
        recording: &dyn Recorded,
        config: Option<&NoiseCalibration>,
    ) -> Result<Self, LogNoiseError> {
        Self::watched(plan, recording, config, &|_| ())
    }

    /// As [`Along::of`]; `watch` is told now and then how large a share of the answers is there.
    ///
    /// # Errors
    /// As [`Along::of`].
    pub fn watched(
        plan: &Plan<'_>,
        recording: &dyn Recorded,
        config: Option<&NoiseCalibration>,
        watch: &(dyn Fn(f64) + Sync),
    ) -> Result<Self, LogNoiseError> {
        let (found_s, needed_s) = (recording.length_s(), plan.unknown_s());
        if found_s <= needed_s {
            return Err(LogNoiseError::TooShort { found_s, needed_s });
        }
        let track = track_watched(plan, recording, watch)?;
        let summary = TrackSummary::of(&track, recording, phases(recording)?, needed_s)?;
        let check = match config {
            Some(source) => Levels::of(recording, &summary.stretches)?
                .map(|levels| compare(source, &levels, recording.rate()))
                .transpose()?,
            None => None,
        };
        let parts = rates::parts(recording)?;
        let rest = RestNoise::in_parts(recording, &summary.stretches, &parts)?;
        let effective = EffectiveNoise::of(recording, &summary.stretches, rest.as_ref())?;
        let mut warnings = report::warnings(plan, &summary);
        warnings.extend(rates::finding(&parts).map(|found| {
            format!("{}; {}", found.text, found.remedy.expect("a bad finding says what to do"))
        }));
        warnings.extend(batched(recording)?);
        // What was given is no estimate.
        if plan.noise.spec().is_estimate() {
            let in_motion = |effective| report::in_motion(plan, &summary, effective, recording.rate());
            warnings.extend(effective.iter().flat_map(in_motion));
            let at_rest =
                rest.iter().flat_map(|rest| report::at_rest(plan, &summary, rest, recording.rate()));
            warnings.extend(at_rest);
        }
        Ok(Self { track, summary, warnings, rest, effective, check })
    }

    /// All but the track, for programs; `log` names the log.
    ///
    /// # Errors
    /// None that is known of: what is written is finite.
    pub fn json(&self, log: &str, plan: &Plan<'_>, recording: &dyn Recorded) -> serde_json::Result<Value> {
        let mut all = serde_json::json!({
            "log": log, "samples": recording.len(), "rate_hz": recording.rate().hz(), "noise": plan.noise.spec(), "every": plan.every(),
            "blocks_of": plan.noise.block(), "summary": self.summary, "warnings": self.warnings, "rest": self.rest, "effective": self.effective,
        });
        if let Some(check) = &self.check {
            all["check"] = serde_json::to_value(check)?;
        }
        Ok(all)
    }
}
