//! How fast the motors turn, relative to hover, at every sample.
//!
//! Off: 0. Standing: from 0 to idle and back to 0 within the standing phases, whose borders so are the motors'. In the
//! air the speed goes as the square root of thrust over weight (thrust ~ speed^2), faded in over the first second
//! after take-off and out over the last before touching down.

use super::config::{IDLE_SPEED, SPIN_UP_S};
use crate::flight::{FlightPlan, Phase};

/// Speed of the motors relative to hover, `t` seconds after the flight's start.
pub(crate) fn motor_speed(plan: &FlightPlan, t: f64) -> f64 {
    let phase = plan.phases.at(t);
    let (begin, end) = plan.phases.span(phase);
    let fade = |since: f64, length: f64| {
        let u = (since / length).clamp(0.0, 1.0);
        u * u * (3.0 - 2.0 * u)
    };
    match phase {
        Phase::RestBefore | Phase::RestAfter => 0.0,
        Phase::IdleBefore => IDLE_SPEED * fade(t - begin, SPIN_UP_S),
        Phase::IdleAfter => IDLE_SPEED * fade(end - t, SPIN_UP_S),
        Phase::TakeOff => {
            IDLE_SPEED + (plan.trajectory.thrust_ratio(t).sqrt() - IDLE_SPEED) * fade(t - begin, 1.0)
        }
        Phase::Landing => {
            IDLE_SPEED + (plan.trajectory.thrust_ratio(t).sqrt() - IDLE_SPEED) * fade(end - t, 1.0)
        }
        Phase::Flying => plan.trajectory.thrust_ratio(t).sqrt(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flight::Flight;

    #[test]
    fn motors_turn_only_when_on_and_never_jump() {
        let plan = FlightPlan::new(Flight::RoomWild, 2);
        let (mut t, mut before) = (0.0, 0.0);
        while t < plan.phases.duration() {
            let speed = motor_speed(&plan, t);
            assert!(plan.phases.at(t).motors_on() || speed == 0.0);
            // At most 1.5 of the way a second at spin-up, and a thrust that moves by less than its own a second.
            assert!((speed - before).abs() < 0.01, "{t}: {before} to {speed}");
            (t, before) = (t + 0.005, speed);
        }
    }
}
