//! One flight, ready for an estimator: samples, a camera, what is true of it.

use dpn_core::camera::CameraModel;
use dpn_core::trajectory::StampedPose;
use dpn_core::{ImuRecording, NoiseTrack, Stamp};
use dpn_train::split::Side;
use nalgebra::Isometry3;
use serde::de::Error as _;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// An IMU recording and the camera beside it, without what the camera saw.
#[derive(Debug, Clone)]
pub struct Recording {
    /// Its name.
    pub name: String,
    /// Its side of the split.
    pub side: Side,
    /// The samples.
    pub imu: ImuRecording,
    /// The lens.
    pub camera: CameraModel,
    /// Points in the camera's frame to the body's.
    pub body_from_cam: Isometry3<f64>,
    /// True poses, in increasing time, where there are any.
    pub truth: Option<Vec<StampedPose>>,
    /// The true deviations of the noise, where it is simulated.
    pub oracle: Option<NoiseTrack>,
    /// What its reader has to say, a line each.
    pub remarks: Vec<String>,
}

/// Where in a recording a run begins; at its first frame where nobody says.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StartAt {
    /// Where VINS-Mono's runs of the comparison begin: 40 s into MH_01's frames, 35 s into MH_02's, at the first frame elsewhere.
    Table,
    /// So many seconds after the first frame.
    Seconds(f64),
}

impl Default for StartAt {
    fn default() -> Self {
        Self::Seconds(0.0)
    }
}

impl StartAt {
    /// Seconds after the first frame of the sequence called `name`.
    pub fn seconds(self, name: &str) -> f64 {
        match self {
            Self::Seconds(seconds) => seconds,
            Self::Table if name.starts_with("MH_01") => 40.0,
            Self::Table if name.starts_with("MH_02") => 35.0,
            Self::Table => 0.0,
        }
    }
}

impl std::fmt::Display for StartAt {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Table => f.write_str("table"),
            Self::Seconds(seconds) => write!(f, "{seconds}"),
        }
    }
}

impl std::str::FromStr for StartAt {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "table" {
            return Ok(Self::Table);
        }
        match text.parse::<f64>() {
            Ok(seconds) if seconds.is_finite() && seconds >= 0.0 => Ok(Self::Seconds(seconds)),
            _ => Err(format!("`{text}` is neither `table` nor a number of seconds from 0")),
        }
    }
}

impl Serialize for StartAt {
    fn serialize<S: Serializer>(&self, out: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::Table => out.serialize_str("table"),
            Self::Seconds(seconds) => out.serialize_f64(*seconds),
        }
    }
}

/// A number, or what [`FromStr`](std::str::FromStr) takes.
impl<'de> Deserialize<'de> for StartAt {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Written {
            Seconds(f64),
            Word(String),
        }
        let text = match Written::deserialize(input)? {
            Written::Seconds(seconds) => seconds.to_string(),
            Written::Word(word) => word,
        };
        text.parse().map_err(D::Error::custom)
    }
}

/// The part of a recording that is run, in seconds after the first frame (or image listed).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Span {
    /// Where it begins.
    pub from_s: f64,
    /// Where it ends; without it at the last frame.
    pub to_s: Option<f64>,
}

impl Span {
    /// From `from_s` to the end.
    pub fn from(from_s: f64) -> Self {
        Self { from_s, to_s: None }
    }

    /// Of items in increasing time those within; a microsecond outside is within, for seconds are rounded when they are written.
    pub fn of<'a, T>(&self, items: &'a [T], stamp: impl Fn(&T) -> Stamp) -> &'a [T] {
        let Some(first) = items.first().map(&stamp) else { return items };
        let begin = first.plus_seconds(self.from_s - 1e-6);
        let from = items.partition_point(|item| stamp(item) < begin);
        let to = self.to_s.map_or(items.len(), |to_s| {
            let end = first.plus_seconds(to_s + 1e-6);
            items.partition_point(|item| stamp(item) <= end)
        });
        &items[from..to.max(from)]
    }
}

/// The first instant at which the body is 2 cm or 1 degree from where it was at `from`; `None` while it stays.
pub fn first_motion(truth: &[StampedPose], from: Stamp) -> Option<Stamp> {
    const FAR_M: f64 = 0.02;
    const FAR_RAD: f64 = std::f64::consts::PI / 180.0;
    let begin = truth.partition_point(|pose| pose.t < from);
    let origin = truth.get(begin)?.world_from_body;
    let moved = |pose: &&StampedPose| {
        (pose.world_from_body.translation.vector - origin.translation.vector).norm() > FAR_M
            || pose.world_from_body.rotation.angle_to(&origin.rotation) > FAR_RAD
    };
    truth[begin..].iter().find(moved).map(|pose| pose.t)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::Vector3;

    #[test]
    fn starts_are_read_and_the_table_knows_its_late_ones() {
        assert_eq!("table".parse(), Ok(StartAt::Table));
        assert_eq!("2.5".parse(), Ok(StartAt::Seconds(2.5)));
        for bad in ["-1", "nan", "late", ""] {
            assert!(bad.parse::<StartAt>().unwrap_err().contains("neither"));
        }
        assert_eq!(StartAt::Table.seconds("MH_01_easy"), 40.0);
        assert_eq!(StartAt::Table.seconds("MH_02"), 35.0);
        assert_eq!(StartAt::Table.seconds("V1_01_easy"), 0.0);
        assert_eq!(StartAt::Seconds(3.0).seconds("MH_01_easy"), 3.0);
    }

    #[test]
    fn a_span_holds_both_its_ends_and_may_be_empty() {
        let stamps: Vec<Stamp> = (0..10).map(|i| Stamp::from_ns(7 + i * 50_000_000)).collect();
        let of = |from_s, to_s| Span { from_s, to_s }.of(&stamps, |t| *t).len();
        assert_eq!((of(0.0, None), of(0.1, None), of(0.1, Some(0.3)), of(0.11, Some(0.14))), (10, 8, 5, 0));
        assert_eq!((of(9.0, None), of(0.3, Some(0.1)), of(0.0, Some(0.0))), (0, 0, 1));
        assert!(Span::from(1.0).of(&[] as &[Stamp], |t| *t).is_empty());
    }

    #[test]
    fn motion_begins_two_centimetres_or_one_degree_away() {
        let pose = |t: i64, x: f64, turn: f64| StampedPose {
            t: Stamp::from_ns(t),
            world_from_body: Isometry3::new(Vector3::x() * x, Vector3::z() * turn),
        };
        let truth = [
            pose(0, 5.0, 0.0),
            pose(1, 0.0, 0.0),
            pose(2, 0.019, 0.01),
            pose(3, 0.0, 0.018),
            pose(4, 0.1, 0.0),
        ];
        assert_eq!(first_motion(&truth, Stamp::from_ns(1)), Some(Stamp::from_ns(3)));
        assert_eq!(first_motion(&truth[1..3], Stamp::from_ns(0)), None);
        assert_eq!(first_motion(&truth, Stamp::from_ns(9)), None);
    }
}
