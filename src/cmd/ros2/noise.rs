//! `dpn ros2 noise`: an IMU in, the same IMU with covariances and diagnostics out.

use super::params::{named, take, unknown};
use super::session::{Next, Session};
use crate::args::Ros2NoiseArgs;
use crate::cmd::noise::plan_of;
use crate::cmd::shipped;
use crate::ui::errln;
use anyhow::Result;
use dpn_core::estimate::NoiseSpec;
use dpn_core::{ImuNoise, ImuRecording, ImuSample, NoiseModel, Sensor, Stamp};
use dpn_ros2::incoming::{Imu, kind};
use dpn_ros2::outgoing::{self, Level, Status};
use dpn_ros2::{Message, Publisher, Quality};

/// Samples after which their rate is known.
const ENOUGH: usize = 200;
/// From one answer to the next.
const EVERY: usize = 10;
/// Samples that wait in DDS.
const SAMPLES: u16 = 2000;
/// So many messages that were passed over are said.
const SHOWN: u64 = 8;

pub(super) fn run(mut args: Ros2NoiseArgs) -> Result<()> {
    let (names, params) = named(&args.node)?;
    for param in &params {
        if param.name == "noise" {
            args.noise = Some(param.value.clone());
        } else if !take(&mut args.node, param)? {
            return Err(unknown(param, "use_sim_time, reliable, noise").into());
        }
    }
    let spec: Option<NoiseSpec> = args.noise.as_deref().map(str::parse).transpose()?;
    let networks = shipped::or_of(args.weights.as_deref())?;
    let mut session = Session::new(names, &args.node)?;
    let quality = Quality { reliable: args.node.reliable, latched: false, depth: SAMPLES };
    let imu = session.listen(&args.node.imu, kind::IMU, quality, ("IMU", false))?;
    let again = session.send("imu/with_covariance", outgoing::kind::IMU)?;
    let mut told = Told {
        samples: 0,
        passed_over: 0,
        last: None,
        noise: None,
        words: "waits for the rate of its samples".to_owned(),
    };

    // The rate first: it says who can be asked.
    let mut first: Vec<ImuSample> = Vec::new();
    let rate = loop {
        match session.next() {
            Next::Asked => return Ok(()),
            Next::Message(message) if message.topic == imu => {
                first.extend(told.take(&message, session.name(imu)).map(|imu| imu.sample()));
            }
            _ => {}
        }
        if session.is_due() {
            session.diagnose(told.status());
        }
        if first.len() == ENOUGH {
            break ImuRecording::new(std::mem::take(&mut first))?.rate();
        }
    };
    let plan = plan_of(spec.as_ref(), rate, EVERY, &networks)?;
    let mut feed = plan.feed()?.watched(plan.noise.spec(), rate);
    let unknown = (plan.unknown_s() * rate.hz()).ceil() as u64;
    errln!("noise by {} at {:.1} Hz, known after {:.1} s", feed.name(), rate.hz(), plan.unknown_s());
    let mut fed = 0;
    loop {
        match session.next() {
            Next::Asked => break,
            Next::Message(message) if message.topic == imu => {
                let Some(imu) = told.take(&message, session.name(imu)) else { continue };
                let noise = feed.feed(&imu.sample());
                fed += 1;
                told.noise = (fed > unknown).then_some(noise);
                send(&again, &imu, told.noise.as_ref());
            }
            _ => {}
        }
        if session.is_due() {
            let judged = feed.judged();
            let outside = |sensor| judged.of(sensor).outside > judged.of(sensor).windows / 2;
            told.words = match (told.noise, [Sensor::Accel, Sensor::Gyro].into_iter().any(outside)) {
                (None, _) => "the first window is not full yet".to_owned(),
                (Some(_), true) => "most windows are unlike all that the networks were trained on".to_owned(),
                (Some(_), false) => {
                    let against = feed.doubts().into_iter().flatten();
                    against.map(|doubt| doubt.words(feed.name())).collect::<Vec<_>>().join("; ")
                }
            };
            session.diagnose(told.status());
        }
    }
    errln!("{} samples, {} passed over, {} never came", told.samples, told.passed_over, session.lost());
    Ok(())
}

/// The message again, with covariances as soon as they are known; before as it came.
fn send(again: &Publisher, imu: &Imu, noise: Option<&ImuNoise>) {
    again.send(match noise {
        Some(noise) => outgoing::imu(imu, noise),
        None => outgoing::imu_as_it_came(imu),
    });
}

/// What was taken and told so far.
struct Told {
    samples: u64,
    passed_over: u64,
    last: Option<Stamp>,
    noise: Option<ImuNoise>,
    /// What somebody should know; empty where nothing is amiss.
    words: String,
}

impl Told {
    /// The sample of a message; none, and words, where it is none or its stamp does not increase.
    fn take(&mut self, message: &Message, place: &str) -> Option<Imu> {
        let problem = match Imu::read(&message.data) {
            Err(error) => format!("such messages {error}"),
            Ok(imu) if !imu.sample().is_finite() => "a value that is not finite".to_owned(),
            Ok(imu) if self.last.is_some_and(|last| imu.t <= last) => {
                format!("a stamp of {} that does not come after the one before", imu.t)
            }
            Ok(imu) => {
                self.last = Some(imu.t);
                self.samples += 1;
                return Some(imu);
            }
        };
        self.passed_over += 1;
        if self.passed_over <= SHOWN {
            errln!("warning: a message on {place}: {problem}; passed over");
        }
        None
    }

    fn status(&self) -> Status {
        let mut values = vec![
            ("samples".to_owned(), self.samples.to_string()),
            ("messages passed over".to_owned(), self.passed_over.to_string()),
        ];
        for sensor in Sensor::ALL {
            for (axis, sigma) in
                ["x", "y", "z"].iter().zip(self.noise.iter().flat_map(|noise| noise.of(sensor)))
            {
                values.push((
                    format!("deviation of {} {axis} [{}]", sensor.name(), sensor.unit()),
                    format!("{sigma:.6}"),
                ));
            }
        }
        let (level, message) = match self.words.as_str() {
            "" => (Level::Ok, "noise is told".to_owned()),
            words => (Level::Warn, words.to_owned()),
        };
        Status { level, name: "noise".to_owned(), message, values }
    }
}
