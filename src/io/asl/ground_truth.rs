//! Ground truth: poses, in some files with velocities and biases.
//!
//! EuRoC's `state_groundtruth_estimate0/data.csv` and TUM-VI's `mocap0/data.csv` share one layout: stamp, position of the body in
//! the world, quaternion `w x y z` of `world_from_body`; then, in fuller files, velocity in the world (11 columns), gyroscope bias
//! and accelerometer bias (17 columns). The header decides which; without one, the number of columns does.

use crate::IoError;
use crate::decimal::TimeUnit;
use crate::pose::{position, rotation};
use crate::row_fault::RowFault;
use crate::rows::Rows;
use dpn_core::truth::{Biases, GroundTruth, TrueState};
use nalgebra::{Isometry3, Vector3};
use std::path::Path;

/// Reads a ground-truth file of ASL's layout.
///
/// # Errors
/// A file that cannot be read or holds no row; other than 8, 11 or 17 columns; a row that holds what is no finite number; a
/// position beyond 1e9 m; a quaternion that is no rotation; stamps that do not increase.
pub fn read(path: &Path) -> Result<GroundTruth, IoError> {
    let bytes = std::fs::read(path).map_err(|e| IoError::reading(path, e))?;
    parse(&bytes, path)
}

const POSE: [&str; 7] = ["p_x", "p_y", "p_z", "q_w", "q_x", "q_y", "q_z"];
const VELOCITY: [&str; 3] = ["v_x", "v_y", "v_z"];
const GYRO_BIAS: [&str; 3] = ["b_w_x", "b_w_y", "b_w_z"];
const ACCEL_BIAS: [&str; 3] = ["b_a_x", "b_a_y", "b_a_z"];

/// The same from bytes at hand; `path` is for messages.
pub(crate) fn parse(bytes: &[u8], path: &Path) -> Result<GroundTruth, IoError> {
    let mut rows = Rows::open(bytes, path)?;
    let width = rows.width();
    if !matches!(width, 8 | 11 | 17) {
        let line = rows.header().map_or(rows.line() + 1, |h| h.line);
        let expected = "8 (stamp, position, quaternion w x y z), 11 (and velocity) and 17 (and biases)";
        return Err(IoError::row(path, line, RowFault::UnknownLayout { found: width, expected }));
    }
    let mut states: Vec<TrueState> = Vec::with_capacity(rows.rows_left());
    while rows.advance()? {
        let t = rows.stamp_after(states.last().map(|s| s.t), 0, TimeUnit::Nanos)?;
        let [x, y, z, qw, qx, qy, qz] = rows.numbers([1, 2, 3, 4, 5, 6, 7], POSE)?;
        let vector =
            |columns, names| -> Result<_, IoError> { Ok(Vector3::from(rows.numbers(columns, names)?)) };
        states.push(TrueState {
            t,
            world_from_body: Isometry3::from_parts(
                position([x, y, z]).map_err(|fault| rows.fault(fault))?,
                rotation([qw, qx, qy, qz]).map_err(|norm| rows.fault(RowFault::BadQuaternion { norm }))?,
            ),
            vel_in_world: if width >= 11 { Some(vector([8, 9, 10], VELOCITY)?) } else { None },
            biases: if width == 17 {
                Some(Biases {
                    gyro: vector([11, 12, 13], GYRO_BIAS)?,
                    accel: vector([14, 15, 16], ACCEL_BIAS)?,
                })
            } else {
                None
            },
        });
    }
    Ok(GroundTruth::new(states).expect("rows were checked: finite, in increasing time, of one width"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(text: &str) -> Result<GroundTruth, IoError> {
        parse(text.as_bytes(), Path::new("data.csv"))
    }

    #[test]
    fn the_quaternion_is_read_scalar_first() {
        // A quarter turn about z takes the body's x axis to the world's y axis.
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let truth = case(&format!("10,1,2,3,{half},0,0,{half}\n")).unwrap();
        let x = truth.states()[0].world_from_body * nalgebra::Point3::new(1.0, 0.0, 0.0);
        assert!((x.coords - Vector3::new(1.0, 3.0, 3.0)).norm() < 1e-12);
        assert!(!truth.has_velocity() && !truth.has_biases());
    }

    #[test]
    fn eleven_and_seventeen_columns_carry_more() {
        let eleven = case("10,1,2,3,1,0,0,0,4,5,6\n").unwrap();
        assert_eq!(eleven.states()[0].vel_in_world, Some(Vector3::new(4.0, 5.0, 6.0)));
        assert!(!eleven.has_biases());
        let seventeen = case("10,1,2,3,1,0,0,0,4,5,6,7,8,9,10,11,12\n").unwrap();
        let biases = seventeen.states()[0].biases.unwrap();
        assert_eq!(biases.gyro, Vector3::new(7.0, 8.0, 9.0));
        assert_eq!(biases.accel, Vector3::new(10.0, 11.0, 12.0));
    }

    #[test]
    fn a_wrong_width_order_or_stamp_is_refused_with_its_line() {
        let error = |text: &str| case(text).unwrap_err().to_string();
        assert!(error("10,1,2,3,1,0,0,0,9\n").starts_with("data.csv:1: 9 columns; 8 (stamp"));
        assert_eq!(
            error("10,1,2,3,1,0,0,0\n20,1,2,3,1,0,0.5,0\n"),
            "data.csv:2: the quaternion has norm 1.118033988749895; a rotation has norm 1"
        );
        assert!(error("10,1,2,3,0,0,0,0\n").contains("norm 0;"));
        assert!(error("10,1,2,3,1,0,0,0\n9,1,2,3,1,0,0,0\n").starts_with("data.csv:2: time goes"));
    }
}
