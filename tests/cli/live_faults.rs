//! `dpn run -` where sensors and their clocks fail: what is wrong is said once, the run goes on, and its end is told however it ends.
#![cfg(unix)]

use crate::bag::{begin, image, sample_on};
use crate::image_logs::{NOISE, rendered};
use crate::run::{Done, dpn, finished};
use dpn_core::{GrayImage, ImuSample, Stamp};
use dpn_io::ImageFolder;
use dpn_io::asl::Sequence;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};

const HOUR: i64 = 3_600_000_000_000;

#[derive(Clone)]
enum Message {
    Sample(ImuSample),
    Image(Stamp, GrayImage),
}

impl Message {
    fn t(&self) -> Stamp {
        match self {
            Self::Sample(sample) => sample.t,
            Self::Image(t, _) => *t,
        }
    }

    fn is_image(&self) -> bool {
        matches!(self, Self::Image(..))
    }

    fn later(self, by: i64) -> Self {
        let t = Stamp::from_ns(self.t().ns() + by);
        match self {
            Self::Sample(sample) => Self::Sample(ImuSample { t, ..sample }),
            Self::Image(_, image) => Self::Image(t, image),
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Sample(sample) => sample_on(1, sample),
            Self::Image(t, pixels) => image(*t, pixels),
        }
    }
}

/// Six seconds of a flight, as they are recorded.
struct Flown {
    calibration: PathBuf,
    messages: Vec<Message>,
}

impl Flown {
    /// Made once for all tests.
    fn get() -> &'static Self {
        static FLOWN: LazyLock<(tempfile::TempDir, Flown)> = LazyLock::new(|| {
            let tmp = tempfile::tempdir().unwrap();
            let flown = Flown::of(tmp.path());
            (tmp, flown)
        });
        &FLOWN.1
    }

    fn of(tmp: &Path) -> Self {
        let dir = rendered(tmp);
        let sequence = Sequence::open(&dir).unwrap();
        let images = ImageFolder::open(&sequence).unwrap();
        let imu = sequence.imu().unwrap();
        let mut messages: Vec<Message> =
            imu.samples().iter().map(|sample| Message::Sample(*sample)).collect();
        let read = |i| images.read(i).unwrap();
        messages.extend((0..images.len()).map(read).map(|image| Message::Image(image.t, image.image)));
        messages.sort_by_key(|message| message.t().ns() + if message.is_image() { 3_000_000 } else { 0 });
        Self { calibration: dir.join("mav0/cam0/sensor.yaml"), messages }
    }

    /// Seconds from the first message on.
    fn at(&self, message: &Message) -> f64 {
        message.t().seconds_since(self.messages[0].t())
    }

    fn begun(&self) -> Child {
        let mut command = dpn();
        command.args(["run", "-", "--calib"]).arg(&self.calibration).args(NOISE);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }

    /// The run over what `change` makes of every message.
    fn run(&self, change: impl Fn(f64, Message) -> Option<Message>) -> Done {
        let changed = self.messages.iter().filter_map(|message| change(self.at(message), message.clone()));
        let bytes = [begin(), changed.flat_map(|message| message.bytes()).collect()].concat();
        let mut child = self.begun();
        let mut stdin = child.stdin.take().unwrap();
        let feeder = std::thread::spawn(move || {
            // One that gives up early reads no more.
            let _ = stdin.write_all(&bytes);
        });
        let done = finished(child.wait_with_output().unwrap());
        feeder.join().unwrap();
        done
    }

    /// The last image's stamp.
    fn end(&self) -> f64 {
        self.messages.iter().rfind(|message| message.is_image()).unwrap().t().ns() as f64 * 1e-9
    }
}

/// The stamps of the poses.
fn stamps(done: &Done) -> Vec<f64> {
    done.stdout.lines().map(|line| line.split(' ').next().unwrap().parse().unwrap()).collect()
}

/// Says so once, and has poses up to the end.
#[track_caller]
fn goes_on(flown: &Flown, done: &Done, words: &str, later: f64) {
    assert_eq!(done.code, Some(0), "{done:?}");
    assert_eq!(done.stderr.matches(words).count(), 1, "no `{words}`: {}", done.stderr);
    let last = *stamps(done).last().unwrap();
    assert!((flown.end() + later - last).abs() < 0.3, "{last} of {}: {}", flown.end() + later, done.stderr);
}

#[test]
fn a_stamp_that_is_wrong_and_a_clock_that_is_set_are_said_once_and_the_run_goes_on() {
    let flown = Flown::get();
    let good = flown.run(|_, message| Some(message));
    assert_eq!(good.code, Some(0), "{good:?}");
    for words in ["clock was set", "a stamp of", "nothing from", "no point is followed"] {
        assert!(!good.stderr.contains(words), "{}", good.stderr);
    }
    for images in [false, true] {
        let sensor = if images { "camera" } else { "IMU" };
        let from = flown.messages.iter().filter(|m| m.is_image() == images && flown.at(m) > 4.0);
        let chosen = from.map(Message::t).next().unwrap();
        let one = flown.run(|_, message| {
            let is = message.is_image() == images && message.t() == chosen;
            Some(if is { message.later(HOUR) } else { message })
        });
        goes_on(flown, &one, &format!("a stamp of the {sensor} ("), 0.0);
        let by = if images { -HOUR } else { HOUR };
        let set = flown.run(|at, message| {
            Some(if message.is_image() == images && at > 4.0 { message.later(by) } else { message })
        });
        let way = if by > 0 { "ahead" } else { "back" };
        let later = if images { 0.0 } else { by as f64 * 1e-9 };
        goes_on(flown, &set, &format!("the {sensor}'s clock was set 3600.000 s {way} at "), later);
        assert_eq!(stamps(&set).len(), stamps(&good).len(), "{}", set.stderr);
    }
    let zeros = flown.run(|_, message| Some(message.clone().later(-message.t().ns())));
    assert_eq!(zeros.code, Some(3), "{zeros:?}");
    assert!(
        zeros.stderr.contains("the IMU's stamps stand at ") && !zeros.stderr.contains("waited for ."),
        "{}",
        zeros.stderr
    );
}

#[test]
fn images_that_end_or_turn_black_and_samples_that_end_are_said() {
    let flown = Flown::get();
    for (images, sensor) in [(true, "camera"), (false, "IMU")] {
        let ended = flown.run(|at, message| (message.is_image() != images || at < 3.0).then_some(message));
        assert_eq!(ended.code, Some(0), "{ended:?}");
        let words = format!("warning: nothing from the {sensor} since ");
        assert_eq!(ended.stderr.matches(&words).count(), 1, "{}", ended.stderr);
    }
    let black = flown.run(|at, message| match message {
        Message::Image(t, image) if at > 3.0 => {
            let dark = vec![0; image.pixels().len()];
            Some(Message::Image(t, GrayImage::new(image.width(), image.height(), dark).unwrap()))
        }
        other => Some(other),
    });
    assert_eq!(black.stderr.matches("warning: no point is followed since ").count(), 1, "{}", black.stderr);
}

#[test]
fn every_end_tells_what_the_run_was_and_silence_is_said_while_the_pipe_is_open() {
    let flown = Flown::get();
    let bytes: Vec<u8> = begin().into_iter().chain(flown.messages.iter().flat_map(Message::bytes)).collect();
    for end in ["-INT", "-TERM", "closed"] {
        let mut child = flown.begun();
        let mut stdin = child.stdin.take().unwrap();
        let mut poses = BufReader::new(child.stdout.take().unwrap());
        let (sent, all) = (bytes.clone(), end != "closed");
        let feeder = std::thread::spawn(move || {
            let _ = stdin.write_all(&sent);
            // Open, and nothing comes.
            stdin
        });
        let mut first = String::new();
        poses.read_line(&mut first).unwrap();
        assert!(!first.is_empty());
        let asked;
        if all {
            let rest = std::thread::spawn(move || {
                let mut text = String::new();
                poses.read_to_string(&mut text).map(|_| text)
            });
            std::thread::sleep(Duration::from_millis(if end == "-INT" { 4000 } else { 200 }));
            asked = Instant::now();
            assert!(Command::new("kill").args([end, &child.id().to_string()]).status().unwrap().success());
            rest.join().unwrap().unwrap();
        } else {
            asked = Instant::now();
            drop(poses);
        }
        let done = finished(child.wait_with_output().unwrap());
        assert!(asked.elapsed() < Duration::from_secs(10), "{end}: {:?}", asked.elapsed());
        assert_eq!(done.code, Some(0), "{end}: {done:?}");
        assert!(done.stderr.contains(" messages passed over\n"), "{end}: {}", done.stderr);
        if end == "-INT" {
            for sensor in ["IMU", "camera"] {
                let words = format!("warning: nothing from the {sensor} since ");
                assert_eq!(done.stderr.matches(&words).count(), 1, "{}", done.stderr);
            }
        }
        drop(feeder.join().unwrap());
    }
}
