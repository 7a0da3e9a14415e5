//! The architecture: drawings whose words and numbers are those of the estimator's configuration and of the networks in use.

use askama::Template;
use dpn_figures::Provenance;
use dpn_pronet::DualProNet;
use dpn_pronet::network::Network;
use dpn_pronet::shape::parameter_count;
use dpn_vio::EstimatorConfig;
use dpn_vio::estimator::FedTracks;

/// A word of the configuration as it is written in a file.
fn word(value: impl serde::Serialize) -> String {
    match serde_json::to_value(value) {
        Ok(serde_json::Value::String(text)) => text,
        other => other.map(|value| value.to_string()).unwrap_or_default(),
    }
}

/// The odometry with DualProNet: what is fed where.
#[derive(Debug, Template)]
#[template(path = "odometry.svg", escape = "html")]
pub(crate) struct OdometryDrawing<'a> {
    pub(crate) estimator: &'a EstimatorConfig,
    /// Of the accelerometer and of the gyroscope.
    pub(crate) networks: [Option<&'a Network>; 2],
    /// What the camera's tracks are.
    pub(crate) camera: &'a str,
    pub(crate) made_by: &'a Provenance,
}

impl OdometryDrawing<'_> {
    fn word(value: impl serde::Serialize) -> String {
        word(value)
    }

    fn parameters(network: &Network) -> usize {
        parameter_count(network.weights.config())
    }

    /// Where the loss begins to count less.
    fn loss_at(&self) -> String {
        let window = &self.estimator.window;
        match self.estimator.fed_tracks {
            FedTracks::White => format!("{} deviations", window.loss_scale),
            FedTracks::Followed => format!("{} px", window.followed_loss_px),
        }
    }
}

/// The sliding window: states, what ties them together, what is forgotten.
#[derive(Debug, Template)]
#[template(path = "window.svg", escape = "html")]
pub(crate) struct WindowDrawing<'a> {
    pub(crate) estimator: &'a EstimatorConfig,
    pub(crate) made_by: &'a Provenance,
}

impl WindowDrawing<'_> {
    fn word(value: impl serde::Serialize) -> String {
        word(value)
    }

    fn held(is_estimated: &bool) -> &'static str {
        if *is_estimated { "estimated" } else { "held" }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drawings_follow_the_configuration() {
        let made_by =
            Provenance { command: "dpn paper".into(), program: "dpn".into(), runs: vec!["a".into()] };
        let mut estimator = EstimatorConfig::default();
        estimator.window.key_frames = 7;
        let text = WindowDrawing { estimator: &estimator, made_by: &made_by }.render().unwrap();
        assert!(text.contains(">x7<") && !text.contains(">x10<"), "{text}");
        let odometry = |estimator: &EstimatorConfig, camera: &str| {
            let drawing = OdometryDrawing { estimator, networks: [None; 2], camera, made_by: &made_by };
            drawing.render().unwrap()
        };
        let text = odometry(&estimator, "tracks, 10 Hz");
        for expected in [
            "7 key frames and the newest",
            "tracks, 10 Hz",
            "covariance: exact",
            "loss: huber at 1.5",
            "dpn paper",
        ] {
            assert!(text.contains(expected), "{expected}: {text}");
        }
        estimator.fed_tracks = FedTracks::Followed;
        let text = odometry(&estimator, "images, followed");
        assert!(text.contains("loss: huber at 0.5 px"), "{text}");
    }
}
