//! Images on their way to tracks: they wait until samples reach them, then the front-end follows points into them.
//!
//! Whether an image or its samples come first makes no difference: an image is worked off when there is a sample at or after its stamp, so that
//! the turn the gyroscope says is the same in any order of arrival.

use super::estimator::FeedError;
use crate::frontend::{Fed, FrameReport, FrontEnd, FrontEndConfig, GyroTurn, turn_of_camera};
use dpn_core::camera::PinholeRadtan;
use dpn_core::config::ConfigFault;
use dpn_core::random::Stream;
use dpn_core::{GrayImage, GrayView, ImuSample, Stamp, TrackFrame};
use nalgebra::{UnitQuaternion, Vector3};
use std::collections::VecDeque;

/// Most images that wait for samples: two seconds at 20 Hz.
pub(super) const MOST_WAITING: usize = 40;

/// The front-end with what waits for it.
#[derive(Debug, Clone)]
pub(super) struct Eye {
    front_end: FrontEnd,
    gyro: GyroTurn,
    body_from_cam: UnitQuaternion<f64>,
    size: [usize; 2],
    waiting: VecDeque<(Stamp, GrayImage)>,
    newest: Option<Stamp>,
    last: Option<FrameReport>,
}

impl Eye {
    pub(super) fn new(
        config: FrontEndConfig,
        camera: PinholeRadtan,
        body_from_cam: UnitQuaternion<f64>,
        seed: u64,
    ) -> Result<Self, Vec<ConfigFault>> {
        let front_end =
            FrontEnd::new(camera, config, &Stream::new(seed)).map_err(|_| config_faults(&config))?;
        Ok(Self {
            front_end,
            gyro: GyroTurn::new(),
            body_from_cam,
            size: camera.size().map(|side| side as usize),
            waiting: VecDeque::new(),
            newest: None,
            last: None,
        })
    }

    /// A sample, in increasing time.
    pub(super) fn feed_imu(&mut self, sample: &ImuSample) {
        // Before the first image nothing is asked of the gyroscope but the sample before it.
        self.gyro.feed(sample);
    }

    /// An image, in increasing time.
    pub(super) fn feed(&mut self, image: GrayView<'_>, t: Stamp) -> Result<(), FeedError> {
        if let Some(last) = self.newest.filter(|last| t <= *last) {
            return Err(FeedError::ImageOutOfOrder { t, last });
        }
        let found = [image.width(), image.height()];
        if found != self.size {
            return Err(FeedError::ImageSize { t, found, camera: self.size });
        }
        if let Some((first, _)) = self.waiting.front().filter(|_| self.waiting.len() >= MOST_WAITING) {
            return Err(FeedError::ImuBehind { t, first: *first, waiting: self.waiting.len() });
        }
        self.newest = Some(t);
        self.waiting.push_back((t, image.to_image()));
        Ok(())
    }

    /// Follows points into images up to `reached`, the newest sample's stamp, until one of them is handed over.
    pub(super) fn look(&mut self, reached: Stamp) -> Option<TrackFrame> {
        while self.waiting.front().is_some_and(|(t, _)| *t <= reached) {
            let (t, image) = self.waiting.pop_front()?;
            let turn = self.gyro.until(t, &Vector3::zeros());
            let turn = turn.map(|turn| turn_of_camera(&turn, &self.body_from_cam));
            let Fed { frame, report } = self.front_end.feed(image.view(), t, turn.as_ref());
            self.last = Some(report);
            if frame.is_some() {
                return frame;
            }
        }
        None
    }

    /// What became of the image last worked off.
    pub(super) fn last(&self) -> Option<&FrameReport> {
        self.last.as_ref()
    }
}

fn config_faults(config: &FrontEndConfig) -> Vec<ConfigFault> {
    use dpn_core::config::Validate;
    config.faults().into_iter().map(|f| ConfigFault { key: format!("front_end.{}", f.key), ..f }).collect()
}
