//! The live door under chance: a recorded stream with messages lost, twice, late and out of order, stamps that jump, sensors that stop, a lens that is covered, a
//! process that is stopped and goes on. Held: no panic and no hang, poses of numbers with stamps that increase, a word on every silence beyond two
//! seconds, and poses again within three seconds of good input.

#[path = "../cli/bag.rs"]
mod bag;

use bag::{begin, image, sample_on};
use dpn_core::{GrayImage, ImuSample, Stamp};
use dpn_io::ImageFolder;
use dpn_io::asl::Sequence;
use dpn_testing::forged::Draw;
use dpn_testing::{Disturbed, SensorFaults};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Seconds of the recording that are played, and from when on nothing is disturbed any more.
const LENGTH_S: f64 = 14.0;
const GOOD_S: f64 = 9.0;
/// A process that takes longer hangs.
const HANGS: Duration = Duration::from_secs(120);

/// A message as it was recorded: when, after how long, and of which sensor.
struct Message {
    t: Stamp,
    at: f64,
    of: Of,
}

enum Of {
    Sample(ImuSample),
    Image(GrayImage),
}

/// A recorded stream.
pub(crate) struct Recorded {
    calibration: PathBuf,
    messages: Vec<Message>,
}

impl Recorded {
    pub(crate) fn of(dir: &Path) -> Self {
        let sequence = Sequence::open(dir).unwrap();
        let images = ImageFolder::open(&sequence).unwrap();
        let imu = sequence.imu().unwrap();
        let first = imu.samples()[0].t;
        let mut messages: Vec<Message> = imu
            .samples()
            .iter()
            .map(|sample| Message { t: sample.t, at: 0.0, of: Of::Sample(*sample) })
            .collect();
        for read in (0..images.len()).map(|i| images.read(i).unwrap()) {
            messages.push(Message { t: read.t, at: 0.003, of: Of::Image(read.image) });
        }
        for message in &mut messages {
            message.at += message.t.seconds_since(first);
        }
        messages.retain(|message| message.at < LENGTH_S);
        messages.sort_by(|a, b| a.at.total_cmp(&b.at));
        Self { calibration: dir.join("mav0/cam0/sensor.yaml"), messages }
    }

    /// The stream as `faults` leave it, in pieces of half a second.
    fn played(&self, faults: &SensorFaults, draw: &mut Draw) -> Vec<Vec<u8>> {
        let mut pieces = vec![begin()];
        let recorded = self.messages.iter().map(|message| (message.at, matches!(message.of, Of::Image(_))));
        for Disturbed { comes_s, place, by_s, dark, wild, says } in faults.played(recorded, draw) {
            let Message { t, of, .. } = &self.messages[place];
            let t = t.plus_seconds(by_s);
            let bytes = match of {
                Of::Sample(sample) => {
                    let said = says.map(|place| &self.messages[place].of);
                    let sample = if let Some(Of::Sample(held)) = said { held } else { sample };
                    let gyro = wild.map_or(sample.gyro, |value| [value; 3]);
                    sample_on(1, &ImuSample { t, gyro, ..*sample })
                }
                Of::Image(shown) if dark => {
                    image(t, &GrayImage::from_fn(shown.width(), shown.height(), |_, _| 0).unwrap())
                }
                Of::Image(shown) => image(t, shown),
            };
            let piece = 1 + (2.0 * comes_s) as usize;
            pieces.resize_with(pieces.len().max(piece + 1), Vec::new);
            pieces[piece].extend(bytes);
        }
        pieces
    }

    /// Plays one plan and looks at what comes of it.
    pub(crate) fn survives(&self, number: usize, seed: u64) {
        let mut draw = Draw::new(seed, &format!("live {number}"));
        let faults = SensorFaults::draw(&mut draw, GOOD_S);
        // The process is stopped for a while after so many seconds of the stream.
        let paused = (draw.share() < 0.2).then(|| draw.share() * LENGTH_S);
        let pieces = self.played(&faults, &mut draw);
        let named = format!("plan {number} of seed {seed}: {faults:?}, paused {paused:?}");
        let mut child = Command::new(env!("CARGO_BIN_EXE_dpn"))
            .args(["run", "-", "--noise", "x1", "--calib"])
            .arg(&self.calibration)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (mut stdin, id) = (child.stdin.take().unwrap(), child.id().to_string());
        let feeder = std::thread::spawn(move || {
            for (place, piece) in pieces.into_iter().enumerate() {
                if paused.is_some_and(|at| (2.0 * at) as usize == place) {
                    for (signal, ms) in [("-STOP", 300), ("-CONT", 0)] {
                        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
                        std::thread::sleep(Duration::from_millis(ms));
                    }
                }
                if stdin.write_all(&piece).is_err() {
                    return;
                }
            }
        });
        let begun = Instant::now();
        let (sender, done) = std::sync::mpsc::channel();
        let pid = child.id().to_string();
        std::thread::spawn(move || sender.send(child.wait_with_output().unwrap()));
        let Ok(done) = done.recv_timeout(HANGS) else {
            let _ = Command::new("kill").args(["-KILL", &pid]).status();
            panic!("hangs after {:?}: {named}", begun.elapsed());
        };
        feeder.join().unwrap();
        let (out, said) = (String::from_utf8(done.stdout).unwrap(), String::from_utf8(done.stderr).unwrap());
        assert!(!said.contains("panicked"), "{named}: {said}");
        assert_eq!(done.status.code(), Some(0), "{named}: {said}");
        self.poses_are_good(&faults, &out, &format!("{named}: {said}"));
        if let Some((images, [from, to])) = faults.stops
            && to - from > 2.2
        {
            let words = format!("nothing from the {} since ", if images { "camera" } else { "IMU" });
            assert!(said.contains(&words), "{named}: {said}");
        }
        // Of what comes as from a file nothing tells both clocks that are set ahead from a gap, nor one that is set by little from what was lost.
        if let Some((of, _, by)) = faults.set
            && by.abs() > 1.0
            && (of != [true; 2] || by < 0.0)
        {
            let words = match of {
                [true, true] => "the IMU's and the camera's clock was set ",
                [true, false] => "the IMU's clock was set ",
                _ => "the camera's clock was set ",
            };
            assert!(said.contains(words), "{named}: {said}");
        }
    }

    fn poses_are_good(&self, faults: &SensorFaults, out: &str, named: &str) {
        let shift = faults.set.filter(|(of, ..)| of[0]).map_or(0.0, |(.., by)| by);
        let first = self.messages[0].t;
        let mut after = 0;
        let mut last = f64::NEG_INFINITY;
        for line in out.lines() {
            let fields: Vec<f64> = line.split(' ').map(|field| field.parse().unwrap()).collect();
            assert!(fields.len() == 8 && fields.iter().all(|value| value.is_finite()), "{line}: {named}");
            let at = fields[0] - first.ns() as f64 * 1e-9;
            // Stamps are the IMU's: where its clock is set they are too.
            let own = if (at - shift).abs() < at.abs() { at - shift } else { at };
            assert!(own > last, "{line} after {last}: {named}");
            last = own;
            after += usize::from((GOOD_S..GOOD_S + 3.0).contains(&own));
        }
        assert!(after > 0, "no pose within 3 s of good input: {named}");
        assert!(last > LENGTH_S - 1.0, "the last pose is at {last} s: {named}");
    }
}
