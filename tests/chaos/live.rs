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

/// What is done to a stream.
#[derive(Debug)]
struct Plan {
    lost: f64,
    twice: f64,
    late: f64,
    jumps: f64,
    /// A sensor's clock is set: which, when, by how many seconds.
    set: Option<(bool, f64, f64)>,
    /// A sensor stops: which, from when to when.
    stops: Option<(bool, [f64; 2])>,
    /// Black images from when to when.
    dark: Option<[f64; 2]>,
    /// The process is stopped for a while after so many seconds of the stream.
    paused: Option<f64>,
}

impl Plan {
    fn draw(draw: &mut Draw) -> Self {
        let mut often = |most: f64| if draw.share() < 0.5 { most * draw.share() } else { 0.0 };
        let [lost, twice, late, jumps] = [often(0.05), often(0.05), often(0.05), often(0.01)];
        let mut span = |most: f64| {
            let from = 2.0 + draw.share() * (GOOD_S - 3.0);
            [from, (from + most * draw.share()).min(GOOD_S)]
        };
        let [set, stops, dark] = [span(0.0), span(4.0), span(4.0)];
        let mut chance = |share: f64| draw.share() < share;
        let [is_set, is_stopped, is_dark, is_paused] = [chance(0.3), chance(0.3), chance(0.3), chance(0.2)];
        let [first, second] = [chance(0.5), chance(0.5)];
        let by = 2.0 + 5000.0 * draw.share();
        let by = if draw.share() < 0.5 { by } else { -by };
        Self {
            lost,
            twice,
            late,
            jumps,
            set: is_set.then_some((first, set[0], by)),
            stops: is_stopped.then_some((second, stops)),
            dark: is_dark.then_some(dark),
            paused: is_paused.then(|| draw.share() * LENGTH_S),
        }
    }
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

    /// The stream as `plan` leaves it, in pieces of half a second.
    fn played(&self, plan: &Plan, draw: &mut Draw) -> Vec<Vec<u8>> {
        let mut pieces = vec![begin()];
        let mut held: Vec<(f64, Vec<u8>)> = Vec::new();
        for Message { t, at, of } in &self.messages {
            let (at, is_image) = (*at, matches!(of, Of::Image(_)));
            let disturbed = at < GOOD_S;
            let stopped =
                plan.stops.is_some_and(|(images, [from, to])| images == is_image && (from..to).contains(&at));
            if stopped || (disturbed && draw.share() < plan.lost) {
                continue;
            }
            let set = plan
                .set
                .filter(|(images, from, _)| *images == is_image && at >= *from)
                .map_or(0.0, |(.., by)| by);
            let jump = if disturbed && draw.share() < plan.jumps { 1e4 * (draw.share() - 0.5) } else { 0.0 };
            let t = t.plus_seconds(set + jump);
            let bytes = match of {
                Of::Sample(sample) => sample_on(1, &ImuSample { t, ..*sample }),
                Of::Image(shown) => {
                    let dark = plan.dark.is_some_and(|[from, to]| (from..to).contains(&at));
                    let black = || GrayImage::from_fn(shown.width(), shown.height(), |_, _| 0).unwrap();
                    if dark { image(t, &black()) } else { image(t, shown) }
                }
            };
            let many = if disturbed && draw.share() < plan.twice { 2 } else { 1 };
            let later = if disturbed && draw.share() < plan.late { 0.2 * draw.share() } else { 0.0 };
            held.extend((0..many).map(|_| (at + later, bytes.clone())));
            held.sort_by(|a, b| a.0.total_cmp(&b.0));
            while held.first().is_some_and(|(due, _)| *due <= at) {
                let piece = 1 + (2.0 * at) as usize;
                pieces.resize_with(pieces.len().max(piece + 1), Vec::new);
                pieces[piece].extend(held.remove(0).1);
            }
        }
        pieces.push(held.into_iter().flat_map(|(_, bytes)| bytes).collect());
        pieces
    }

    /// Plays one plan and looks at what comes of it.
    pub(crate) fn survives(&self, number: usize, seed: u64) {
        let mut draw = Draw::new(seed, &format!("live {number}"));
        let plan = Plan::draw(&mut draw);
        let pieces = self.played(&plan, &mut draw);
        let named = format!("plan {number} of seed {seed}: {plan:?}");
        let mut child = Command::new(env!("CARGO_BIN_EXE_dpn"))
            .args(["run", "-", "--noise", "x1", "--calib"])
            .arg(&self.calibration)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (mut stdin, id, paused) = (child.stdin.take().unwrap(), child.id().to_string(), plan.paused);
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
        self.poses_are_good(&plan, &out, &format!("{named}: {said}"));
        if let Some((images, [from, to])) = plan.stops
            && to - from > 2.2
        {
            let words = format!("nothing from the {} since ", if images { "camera" } else { "IMU" });
            assert!(said.contains(&words), "{named}: {said}");
        }
        if let Some((images, ..)) = plan.set {
            let words = format!("the {}'s clock was set ", if images { "camera" } else { "IMU" });
            assert!(said.contains(&words), "{named}: {said}");
        }
    }

    fn poses_are_good(&self, plan: &Plan, out: &str, named: &str) {
        let shift = plan.set.filter(|(images, ..)| !images).map_or(0.0, |(.., by)| by);
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
