//! Trajectories in bags: the poses of one topic of `nav_msgs/Odometry`, `geometry_msgs/PoseStamped`, `PoseWithCovarianceStamped` or `TransformStamped`.
//!
//! Behind the header, of an Odometry and a transform behind the child's frame too, stand position and quaternion `x y z w`, seven doubles. Source:
//! nav_msgs/Odometry.msg, geometry_msgs/PoseStamped.msg, TransformStamped.msg.

use crate::budget::Budget;
use crate::fields::{Encoding, Fields, Undecodable};
use crate::messages::Messages;
use crate::topics::{shortened, similar};
use crate::{Kind, LogError, bag};
use dpn_core::Stamp;
use dpn_core::trajectory::StampedPose;
use dpn_io::{printable, stamped_pose};
use std::collections::HashMap;
use std::path::Path;

/// What a bag has of a trajectory.
#[derive(Debug, Clone, PartialEq)]
pub struct BagPoses {
    /// In increasing time; of several at one stamp the first.
    pub poses: Vec<StampedPose>,
    /// Covariances of position and of small turns about the axes of the poses' frame, row by row, of those that say one.
    pub covariances: Vec<(Stamp, [f64; 36])>,
    /// What was left out, and where the bag ends early.
    pub remarks: Vec<String>,
}

/// Whether `path` is a bag, by its first bytes or its files.
pub fn is_bag(path: &Path) -> bool {
    matches!(Kind::of(path), Ok(Kind::Rosbag1 | Kind::Mcap | Kind::Sqlite | Kind::Rosbag2))
}

/// Reads the poses of `topic`, or of the only topic that has some; of whatever frames they are.
///
/// # Errors
/// No bag; no topic of poses, several and no choice, one that is not there or whose messages are written in a way that is not known.
pub fn read_bag_poses(path: &Path, topic: Option<&str>) -> Result<BagPoses, LogError> {
    let mut found =
        Found { all: Vec::new(), names: HashMap::new(), numbers: HashMap::new(), budget: Budget::new(None) };
    let (_, damage) = bag::read(path, None, &mut found)?;
    let Topic { name, encoding, mut poses, mut covariances, bad, .. } = found.choose(path, topic)?;
    if let Err(encoding) = encoding {
        return Err(LogError::Encoding { path: path.to_path_buf(), topic: name, encoding });
    }
    poses.sort_by_key(|pose| pose.t);
    poses.dedup_by_key(|pose| pose.t);
    covariances.sort_by_key(|(t, _)| *t);
    covariances.dedup_by_key(|(t, _)| *t);
    let mut remarks: Vec<String> = damage.into_iter().collect();
    if bad > 0 {
        remarks.push(format!("{bad} message(s) on {name} are no poses; they are left out"));
    }
    Ok(BagPoses { poses, covariances, remarks })
}

/// What stands before a message's pose, and behind it.
#[derive(Debug, Clone, Copy)]
struct Layout {
    /// A child's frame before it.
    has_child: bool,
    with_covariance: bool,
}

/// That of a type whose messages are poses.
fn layout(kind: &str) -> Option<Layout> {
    let (has_child, with_covariance) = match kind.replace("/msg/", "/").as_str() {
        "nav_msgs/Odometry" => (true, true),
        "geometry_msgs/TransformStamped" => (true, false),
        "geometry_msgs/PoseStamped" => (false, false),
        "geometry_msgs/PoseWithCovarianceStamped" => (false, true),
        _ => return None,
    };
    Some(Layout { has_child, with_covariance })
}

struct Topic {
    name: String,
    /// None where it has no poses.
    layout: Option<Layout>,
    encoding: Result<Encoding, String>,
    poses: Vec<StampedPose>,
    covariances: Vec<(Stamp, [f64; 36])>,
    /// Messages that cannot be read, or are no pose.
    bad: usize,
}

struct Found {
    all: Vec<Topic>,
    names: HashMap<String, usize>,
    numbers: HashMap<u32, usize>,
    budget: Budget,
}

impl Found {
    fn choose(mut self, path: &Path, wanted: Option<&str>) -> Result<Topic, LogError> {
        let path = path.to_path_buf();
        let has: Vec<usize> = (0..self.all.len()).filter(|i| self.all[*i].layout.is_some()).collect();
        let listed = |of: &[usize]| {
            shortened(of.iter().map(|i| self.all[*i].name.clone()).collect::<Vec<_>>().into_iter())
        };
        let index = match (wanted, &has[..]) {
            (_, []) => {
                let every: Vec<usize> = (0..self.all.len()).collect();
                return Err(LogError::NoPoses { path, topics: listed(&every) });
            }
            (Some(wanted), all) => match all.iter().find(|i| self.all[**i].name == wanted) {
                Some(index) => *index,
                None => {
                    let similar = similar(all.iter().map(|i| self.all[*i].name.as_str()), wanted);
                    let topics = listed(all);
                    return Err(LogError::NoTopic { path, wanted: printable(wanted), topics, similar });
                }
            },
            (None, [only]) => *only,
            (None, several) => {
                let one = self.all[several[0]].name.clone();
                return Err(LogError::SeveralPoseTopics { path, topics: listed(several), one });
            }
        };
        Ok(self.all.swap_remove(index))
    }
}

impl Messages for Found {
    fn next_file(&mut self) {
        self.numbers.clear();
    }

    fn declare(&mut self, number: u32, name: &str, kind: &str, encoding: Result<Encoding, String>) -> bool {
        let name = printable(name);
        let index = *self.names.entry(name.clone()).or_insert_with(|| {
            let encoding = encoding.map_err(|foreign| printable(&foreign));
            self.all.push(Topic {
                name,
                layout: layout(kind),
                encoding,
                poses: Vec::new(),
                covariances: Vec::new(),
                bad: 0,
            });
            self.all.len() - 1
        });
        self.numbers.insert(number, index);
        self.all[index].layout.is_some()
    }

    fn message(&mut self, number: u32, received_ns: i64, data: &[u8]) {
        let Some(topic) = self.numbers.get(&number).map(|index| &mut self.all[*index]) else { return };
        let (Some(layout), Ok(encoding)) = (topic.layout, &topic.encoding) else { return };
        match pose(data, *encoding, layout, received_ns) {
            Ok(Some((pose, covariance))) => {
                topic.covariances.extend(covariance.map(|covariance| (pose.t, covariance)));
                topic.poses.push(pose);
            }
            Ok(None) | Err(_) => topic.bad += 1,
        }
    }

    fn budget(&mut self) -> &mut Budget {
        &mut self.budget
    }
}

/// A pose, and its covariance where the message says one.
type PoseSaid = (StampedPose, Option<[f64; 36]>);

/// The pose of a message, at the header's stamp, else the bag's; none where it is no pose.
fn pose(
    data: &[u8],
    encoding: Encoding,
    Layout { has_child, with_covariance }: Layout,
    received_ns: i64,
) -> Result<Option<PoseSaid>, Undecodable> {
    let mut fields = Fields::new(data, encoding)?;
    let mut read = || {
        let t_ns = fields.header()?.t_ns;
        if has_child {
            fields.counted()?;
        }
        let mut values = [0.0; 7];
        for value in &mut values {
            *value = fields.f64()?;
        }
        let mut covariance = [0.0; 36];
        let whole =
            with_covariance && covariance.iter_mut().all(|value| fields.f64().map(|v| *value = v).is_some());
        // Zeros throughout are not known.
        let known =
            whole && (0..6).all(|k| covariance[7 * k] > 0.0) && covariance.iter().all(|v| v.is_finite());
        Some((t_ns, values, known.then_some(covariance)))
    };
    let (t_ns, [x, y, z, qx, qy, qz, qw], covariance) = read().ok_or(Undecodable::Short)?;
    let t = Stamp::from_ns(if t_ns == 0 { received_ns } else { t_ns });
    Ok(stamped_pose(t, [x, y, z], [qw, qx, qy, qz]).map(|pose| (pose, covariance)))
}
