//! A flight's trajectory and phases, a function of its name and a seed alone.
//!
//! Segment `i` of a spline depends on control points `i` to `i + 5`. So the body stands exactly until the segment that
//! first touches a moved control point, and again once the last moved one is out of reach; phases begin and end
//! on those knots, and "standing" means standing to the last bit.

use super::figures::Pen;
use super::name::Flight;
use super::phase::Phases;
use crate::trajectory::{ORDER, Trajectory, UniformSpline};
use dpn_core::random::Stream;

/// Where a flight goes and when it does what.
#[derive(Debug, Clone, PartialEq)]
pub struct FlightPlan {
    /// Which flight.
    pub flight: Flight,
    /// Pose, velocity, rates at any time.
    pub trajectory: Trajectory,
    /// When each phase begins and ends.
    pub phases: Phases,
}

const LIFT_S: f64 = 4.0;
const IDLE_AFTER_S: f64 = 2.5;
const REST_AFTER_S: f64 = 4.0;

impl FlightPlan {
    /// Plans `flight`; the same flight and seed give the same plan.
    pub fn new(flight: Flight, seed: u64) -> Self {
        let character = flight.character();
        let knot = character.knot_s;
        let knots = |seconds: f64| (seconds / knot).round() as usize;
        let (rest, idle, lift) = (knots(character.rest_s), knots(character.idle_s), knots(LIFT_S));
        let (flying, idle_after, rest_after) =
            (knots(character.flying_s), knots(IDLE_AFTER_S), knots(REST_AFTER_S));

        let rng = Stream::new(seed).named("flight").named(flight.name()).named("path").rng();
        let mut pen = Pen::new(&character, rng);
        // Control points 0 to standing + 4 are equal, so segments 0 to standing - 1 stand.
        pen.stand(rest + idle + ORDER - 1);
        let height = 0.5 * (character.floor + character.ceiling.min(2.0));
        let reach = ORDER - 1;
        pen.lift(height, lift - reach);
        pen.fly(flying + reach);
        // One point more than on the way up: the last is on the ground and belongs to the first standing segment.
        pen.lift(0.0, lift - reach + 1);
        pen.stand(idle_after + rest_after + reach - 1);

        let phases = Phases::from_lengths(
            [rest, idle, lift, flying, lift, idle_after, rest_after].map(|n| n as f64 * knot),
        );
        let position = UniformSpline::new(knot, pen.position);
        let trajectory = Trajectory::new(position, UniformSpline::new(knot, pen.yaw));
        Self { flight, trajectory, phases }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::Phase;
    use nalgebra::Vector3;

    #[test]
    fn the_body_stands_exactly_where_the_phase_says_so_and_moves_elsewhere() {
        for flight in Flight::ALL {
            let plan = FlightPlan::new(flight, 7);
            assert!((plan.phases.duration() - plan.trajectory.duration()).abs() < 1e-9);
            for phase in Phase::ALL {
                let (begin, end) = plan.phases.span(phase);
                let steps = ((end - begin) / 0.01) as usize;
                for i in 1..steps {
                    let at = plan.trajectory.state(begin + 0.01 * i as f64);
                    let ideal = at.specific_force_in_body == Vector3::new(0.0, 0.0, 9.81)
                        && at.gyro_in_body == Vector3::zeros()
                        && at.vel_in_world == Vector3::zeros();
                    let inside = i > 10 && i + 10 < steps;
                    assert!(!phase.stands() || ideal, "{flight} {} moves", phase.name());
                    assert!(phase.stands() || !inside || !ideal, "{flight} {} stands", phase.name());
                }
            }
        }
    }

    #[test]
    fn every_flight_can_be_flown_and_has_the_pace_of_its_kin() {
        for (flight, seed) in Flight::ALL.into_iter().flat_map(|f| (1..=6).map(move |seed| (f, seed))) {
            let plan = FlightPlan::new(flight, seed);
            let duration = plan.phases.duration();
            assert!((60.0..=150.0).contains(&duration), "{flight}: {duration} s");
            let (begin, end) = plan.phases.span(Phase::Flying);
            let (mut speed, mut rate, mut n) = (0.0, 0.0, 0.0);
            let mut t = begin;
            while t < end {
                let at = plan.trajectory.state(t);
                let thrust = plan.trajectory.thrust_ratio(t);
                assert!((0.5..1.7).contains(&thrust), "{flight} at {t}: thrust {thrust}");
                let tilt = (at.world_from_body * Vector3::z()).z.acos();
                assert!(tilt < 0.7, "{flight} at {t}: tilt {tilt} rad");
                assert!(at.vel_in_world.norm() < 5.0, "{flight} at {t}: {}", at.vel_in_world.norm());
                assert!(at.gyro_in_body.norm() < 5.0, "{flight} at {t}: {}", at.gyro_in_body.norm());
                speed += at.vel_in_world.norm();
                rate += at.gyro_in_body.norm();
                n += 1.0;
                t += 0.01;
            }
            let (speed, rate) = (speed / n, rate / n);
            // EuRoC: .32 to .99 m/s, .16 to .59 rad/s; hover is slower on purpose.
            assert!((0.03..1.3).contains(&speed), "{flight}: {speed} m/s");
            assert!((0.05..1.0).contains(&rate), "{flight}: {rate} rad/s");
        }
    }

    #[test]
    fn nothing_jumps_where_phases_meet() {
        for flight in Flight::ALL {
            let plan = FlightPlan::new(flight, 4);
            for phase in Phase::ALL.into_iter().skip(1) {
                let border = plan.phases.span(phase).0;
                let (a, b) = (plan.trajectory.state(border - 1e-8), plan.trajectory.state(border + 1e-8));
                // Jerk and angular acceleration are below 100, times 2e-8 s.
                assert!((a.position_in_world - b.position_in_world).norm() < 1e-6);
                assert!((a.vel_in_world - b.vel_in_world).norm() < 1e-6);
                assert!((a.specific_force_in_body - b.specific_force_in_body).norm() < 1e-5);
                assert!((a.gyro_in_body - b.gyro_in_body).norm() < 1e-5);
                assert!(a.world_from_body.angle_to(&b.world_from_body) < 1e-6);
            }
        }
    }

    #[test]
    fn the_same_name_and_seed_give_the_same_plan_and_another_seed_another() {
        let plan = |seed| FlightPlan::new(Flight::RoomWild, seed);
        assert_eq!(plan(5), plan(5));
        assert_ne!(plan(5).trajectory.pose(30.0), plan(6).trajectory.pose(30.0));
    }
}
