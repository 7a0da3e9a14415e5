//! What a network is trained on and how.

use dpn_core::config::{ConfigFault, Limit, Validate};

dpn_core::settings!(
    /// A training of an inertial network. Sequences are folders of ASL's layout below the data's folder, or `LOG=TRAJECTORY`.
    pub struct InertialConfig {
        /// What its networks are called in tables.
        pub name: String = "inertial".to_owned(),
        /// Sequences to train on; all of them.
        pub train: Vec<String> = Vec::new(),
        /// Sequences to be scored, never looked at before.
        pub test: Vec<String> = Vec::new(),
        /// Seed of all draws. Default 0.
        pub seed: u64 = 0,
        /// Steps of the optimiser. Default 300: chosen by leaving out EuRoC's training sequences one by one.
        pub steps: u64 = 300 => 1..=1_000_000,
        /// Windows a step. Default 8.
        pub batch: usize = 8 => 1..=1000,
        /// Samples a window, a multiple of the longest span. Default 2048.
        pub window: usize = 2048,
        /// Learning rate at the first step; it falls to nothing along a cosine. Default .003.
        pub learning_rate: f64 = 3e-3 => Limit::AtMost(1.0),
        /// AdamW's decay. Default .1.
        pub weight_decay: f64 = 0.1 => 0.0..=1.0,
        /// Share of the running mean of weights that a step keeps. Default .995.
        pub ema: f64 = 0.995,
        /// Samples over which products of increments are held against true turns, powers of two. Default 32 and 512, chosen as `steps` was; the papers have 16 and 32.
        pub spans: Vec<usize> = vec![32, 512],
        /// Where the loss turns from squares to distances \[rad\]. Default .005.
        pub huber_rad: f64 = 0.005 => Limit::Positive,
        /// Deviation of white noise on what the network sees, gyroscope \[rad/s\] and accelerometer \[m/s^2\]: more than any sensor's, so that little is learned by heart. Default .02, .2, chosen as `steps` was.
        pub noise: [f64; 2] = [0.02, 0.2],
        /// Half the range of a bias on readings, one a window, gyroscope and accelerometer. Default .001, .001.
        pub bias: [f64; 2] = [1e-3, 1e-3],
        /// The correction is averaged over so many seconds of past where it is scored. Default 20, chosen in the same way.
        pub average_s: f64 = 20.0 => Limit::NotNegative,
        /// Deviation of the body's velocity \[m/s\], by which gravity tells the bias across it; 0: gravity is not asked. Where it is not given, leaving out the recordings of `train` one by one chooses it.
        pub speed: Option<f64> = None,
    }
);

impl Validate for InertialConfig {
    fn faults(&self) -> Vec<ConfigFault> {
        let mut faults = self.outside();
        let both = self.train.iter().find(|name| self.test.contains(name));
        let word = both.map_or("empty", String::as_str);
        faults.check(
            !self.train.is_empty() && both.is_none(),
            "train",
            word,
            "sequences, none of them in `test`: a score on what was learned from says nothing",
        );
        let longest = self.spans.iter().copied().max().unwrap_or(0);
        let are_powers = self.spans.iter().all(|span| span.is_power_of_two());
        faults.check(longest > 0 && are_powers, "spans", format!("{:?}", self.spans), "powers of two");
        let window = self.window;
        let fits = (32..=1 << 20).contains(&window) && longest > 0 && window.is_multiple_of(longest);
        faults.check(fits, "window", window, "32 or more, a multiple of the longest of `spans`");
        faults.check((0.0..1.0).contains(&self.ema), "ema", self.ema, "0 or more and below 1");
        for (key, values) in [("noise", self.noise), ("bias", self.bias)] {
            values.into_iter().for_each(|value| faults.not_negative(key, value));
        }
        faults.not_negative("speed", self.speed.unwrap_or(0.0));
        faults.0
    }
}
