//! Delayed marginalisation: the prior made again, at what is believed today, from key frames that the window has let go.
//!
//! A prior is linearised where its states stood when they left, and stays there; scale and biases of a young flight move on. So a second window
//! goes on beside the one that is solved. It has some key frames more and is not solved with each frame: the states of the frames that both have
//! are copied, and its older frames go along with them as one body. Every so many key frames it is solved as a whole, what is beyond its length
//! leaves it for good, and its older frames are let go once more in a copy, each at its new place. What stays is the window, with a prior that knows
//! of it. After von Stumberg and Cremers, DM-VIO (2022), whose delayed graph is asked when scale or bias have left where they were linearised; here it
//! is asked by count.

use crate::window::{Leaving, Seen, Window};

dpn_core::settings!(
    /// Settings of delayed marginalisation.
    #[derive(Copy, Eq)]
    pub struct DelayedConfig {
        /// Whether there is a second window.
        pub enabled: bool = true,
        /// Key frames that the second window has more than the first; 1 to 100.
        pub key_frames: usize = 5 => 1..=100,
        /// Key frames from one renewal of the prior to the next, by which the second window grows meanwhile; 1 to 100.
        pub every: usize = 10 => 1..=100,
    }
);

/// The window that goes on beside.
#[derive(Debug, Clone)]
pub(super) struct Delayed {
    window: Window,
    every: usize,
    /// Key frames since the prior was made again.
    since: usize,
}

impl Delayed {
    /// From what `window` holds; `None` where nothing is to be delayed.
    pub(super) fn beside(window: &Window, config: DelayedConfig) -> Option<Self> {
        config.enabled.then(|| {
            let mut window = window.clone();
            window.config.key_frames += config.key_frames;
            Self { window, every: config.every, since: 0 }
        })
    }

    /// The window, which the levels that are learned are told too.
    pub(super) fn window(&mut self) -> &mut Window {
        &mut self.window
    }

    /// Takes in the frame that `window` has just taken in with the sightings `seen`.
    pub(super) fn enter(&mut self, window: &Window, seen: &[Seen]) {
        let newest = window.newest().expect("a frame was just added");
        self.window.add_frame(newest.t, newest.state, newest.preint.clone(), seen);
    }

    /// Takes over what `window`, which has the same newest frames, has just found.
    pub(super) fn take_estimates(&mut self, window: &Window) {
        self.window.take_estimates(window);
    }

    /// Follows `window`, which has just let a frame go. Where it is time, its prior is made again.
    pub(super) fn follow(&mut self, window: &mut Window, leaving: Leaving) {
        if leaving == Leaving::SecondNewest {
            self.window.slide(leaving);
            return;
        }
        self.since += 1;
        if self.since >= self.every {
            self.since = 0;
            self.renew(window);
        }
    }

    /// Solves the larger window, lets go what is beyond its length, and has `window` go on with the prior of all but its newest frames. Only from a
    /// window that has just been solved may frames leave: where its older and its newer frames do not agree yet, what ties them together is read
    /// as news of the scale.
    fn renew(&mut self, window: &mut Window) {
        self.window.triangulate();
        self.window.optimise();
        self.window.reject_outliers();
        self.window.slide_oldest(self.window.frames().len().saturating_sub(self.window.config.key_frames));
        let mut renewed = self.window.copy();
        renewed.config = window.config;
        std::mem::swap(&mut renewed.scratch, &mut window.scratch);
        renewed.slide_oldest(renewed.frames().len() - window.frames().len());
        *window = renewed;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::init::tests::{Scene, body_from_cam, gentle_flight};
    use crate::window::WindowConfig;
    use crate::window::tests::{config as converging, seen, truth};
    use nalgebra::Vector3;

    const FRAMES: usize = 10;

    /// The newest position after all frames, in a window that slides; its first frames begin with a scale of 1.3 and leave without having been solved.
    fn newest(scene: &Scene, key_frames: usize, config: DelayedConfig) -> Vector3<f64> {
        let mut window = Window::new(WindowConfig { key_frames, ..converging() }, body_from_cam());
        let mut delayed = None;
        for k in 0..FRAMES {
            let mut state = truth(scene, k);
            state.vel_in_world *= 1.3;
            state.world_from_body.translation.vector *= 1.3;
            let preint = k.checked_sub(1).map(|p| scene.preints[p].clone());
            let seen = seen(scene, k, 3);
            window.add_frame(scene.frames[k].t, state, preint, &seen);
            window.triangulate();
            match &mut delayed {
                None => {
                    window.anchor([0.3, 0.1]);
                    delayed = Some(Delayed::beside(&window, config));
                }
                Some(delayed) => {
                    delayed.iter_mut().for_each(|delayed| delayed.enter(&window, &seen));
                    if window.is_full() {
                        delayed.iter_mut().for_each(|delayed| delayed.take_estimates(&window));
                        window.slide(Leaving::Oldest);
                        delayed.iter_mut().for_each(|delayed| delayed.follow(&mut window, Leaving::Oldest));
                    }
                }
            }
        }
        window.triangulate();
        window.optimise();
        window.newest().expect("frames were added").state.world_from_body.translation.vector
    }

    #[test]
    fn a_prior_that_is_made_again_stands_for_what_has_left_as_if_it_were_there() {
        for seed in 0..6 {
            let scene = Scene::new(&gentle_flight(seed), FRAMES, 0.15, 0.5, seed);
            let none = DelayedConfig { enabled: false, ..DelayedConfig::default() };
            let all = newest(&scene, FRAMES, none);
            let once = (newest(&scene, 4, none) - all).norm();
            let again = (newest(&scene, 4, DelayedConfig { enabled: true, key_frames: FRAMES, every: 1 })
                - all)
                .norm();
            assert!(again < 0.02 * once, "seed {seed}: {again} and {once} m off");
        }
    }
}
