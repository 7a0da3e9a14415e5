//! `/tf_static`: frames that stand still on one another.

use crate::incoming::Transform;
use nalgebra::Isometry3;
use std::collections::BTreeMap;

/// A chain of frames is not longer: one that is goes in a circle.
const LONGEST: usize = 100;
/// More frames than any robot has are not kept.
const MOST: usize = 10_000;

/// A forest of frames; each has one parent at most, the one told last.
#[derive(Debug, Clone, Default)]
pub struct StaticFrames {
    parents: BTreeMap<String, (String, Isometry3<f64>)>,
}

impl StaticFrames {
    /// Takes transforms in; names may begin with a slash, as tf's old ones do.
    pub fn take(&mut self, transforms: Vec<Transform>) {
        for transform in transforms {
            let [child, parent] = [&transform.child, &transform.parent].map(|name| plain(name));
            if self.parents.len() < MOST || self.parents.contains_key(&child) {
                self.parents.insert(child, (parent, transform.parent_from_child));
            }
        }
    }

    /// Points in the frame `from` to the frame `to`; none where no chain leads from one to the other.
    pub fn between(&self, to: &str, from: &str) -> Option<Isometry3<f64>> {
        let (to, from) = (self.up(to)?, self.up(from)?);
        // The first frame of one chain that the other has.
        let (common_from_from, common_from_to) = from
            .iter()
            .find_map(|(name, down)| to.iter().find(|(other, _)| other == name).map(|(_, up)| (down, up)))?;
        Some(common_from_to.inverse() * common_from_from)
    }

    /// The frame and those above it, each with where the frame lies in it.
    fn up(&self, frame: &str) -> Option<Vec<(String, Isometry3<f64>)>> {
        let mut chain = vec![(plain(frame), Isometry3::identity())];
        while let Some((name, pose)) = chain.last() {
            let Some((parent, parent_from_child)) = self.parents.get(name) else { return Some(chain) };
            let next = (parent.clone(), parent_from_child * pose);
            if chain.len() == LONGEST {
                return None;
            }
            chain.push(next);
        }
        None
    }
}

fn plain(name: &str) -> String {
    name.strip_prefix('/').unwrap_or(name).to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Point3, Translation3, UnitQuaternion};

    fn transform(parent: &str, child: &str, x: f64, yaw: f64) -> Transform {
        let pose = Isometry3::from_parts(
            Translation3::new(x, 0.0, 0.0),
            UnitQuaternion::from_euler_angles(0.0, 0.0, yaw),
        );
        Transform { parent: parent.to_owned(), child: child.to_owned(), parent_from_child: pose }
    }

    #[test]
    fn frames_are_joined_over_the_nearest_that_both_hang_on() {
        let mut frames = StaticFrames::default();
        frames.take(vec![
            transform("base", "imu", 1.0, 0.0),
            transform("/base", "mast", 2.0, std::f64::consts::FRAC_PI_2),
        ]);
        assert_eq!(frames.between("imu", "cam"), None);
        frames.take(vec![transform("mast", "/cam", 3.0, 0.0)]);
        // One metre before the camera: base (2, 4), and one metre less from the IMU on.
        let seen = frames.between("imu", "cam").unwrap() * Point3::new(1.0, 0.0, 0.0);
        assert!((seen - Point3::new(1.0, 4.0, 0.0)).norm() < 1e-12, "{seen}");
        let back = frames.between("cam", "imu").unwrap() * seen;
        assert!((back - Point3::new(1.0, 0.0, 0.0)).norm() < 1e-12, "{back}");
        assert_eq!(frames.between("imu", "imu"), Some(Isometry3::identity()));
        // A circle leads nowhere.
        frames.take(vec![transform("cam", "base", 1.0, 0.0)]);
        assert_eq!(frames.between("other", "cam"), None);
    }
}
