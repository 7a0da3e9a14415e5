//! What tells the flights apart: room, speed, turning, mix of figures, and how hard the frame shakes.
//!
//! Mean speeds and rates are near those of EuRoC's eleven sequences (Burri et al., "The EuRoC micro aerial vehicle
//! datasets", IJRR 2016): .32 to .99 m/s by their ground truth, .16 to .59 rad/s by their gyroscope smoothed over .25 s.
//! Vibration levels follow the median residual deviations of the same sequences.

use super::name::Flight;

/// The figures a flight is put together from, with the share each has of the draws.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Mix {
    pub hover: f64,
    pub line: f64,
    pub circle: f64,
    pub eight: f64,
}

/// How one flight is flown.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Character {
    /// Half width of the flight space in x and y, lowest and highest z \[m\].
    pub half_width: f64,
    pub floor: f64,
    pub ceiling: f64,
    /// Time in the air between take-off and landing \[s\].
    pub flying_s: f64,
    /// Standing with motors off, and with motors on, before take-off \[s\].
    pub rest_s: f64,
    pub idle_s: f64,
    /// Mean speed along a figure \[m/s\]; each figure draws between .7 and 1.3 of it.
    pub speed: f64,
    /// The heading's mean rate \[rad/s\]; each figure draws between -1.3 and 1.3 of it.
    pub yaw_rate: f64,
    /// Knots of the splines \[s\]: shorter is livelier.
    pub knot_s: f64,
    /// Control corrections: deviation of a control point from the figure \[m\], of the heading \[rad\].
    pub correction: f64,
    pub yaw_correction: f64,
    pub mix: Mix,
    /// Vibration relative to the typical one, accelerometer x, y, z and gyroscope x, y, z.
    pub accel_level: [f64; 3],
    pub gyro_level: [f64; 3],
}

const LINES: Mix = Mix { hover: 0.15, line: 0.75, circle: 0.1, eight: 0.0 };
const CURVES: Mix = Mix { hover: 0.1, line: 0.2, circle: 0.4, eight: 0.3 };
const MIXED: Mix = Mix { hover: 0.1, line: 0.4, circle: 0.25, eight: 0.25 };

impl Flight {
    pub(crate) fn character(self) -> Character {
        let hall = Character {
            half_width: 6.0,
            floor: 0.8,
            ceiling: 4.0,
            flying_s: 100.0,
            rest_s: 8.0,
            idle_s: 5.0,
            speed: 0.5,
            yaw_rate: 0.25,
            knot_s: 0.4,
            correction: 0.008,
            yaw_correction: 0.02,
            mix: LINES,
            accel_level: [1.04, 0.98, 1.0],
            gyro_level: [1.0, 1.02, 1.02],
        };
        let room = Character {
            half_width: 2.2,
            ceiling: 2.2,
            flying_s: 75.0,
            rest_s: 6.0,
            idle_s: 4.0,
            yaw_rate: 0.6,
            mix: MIXED,
            accel_level: [1.1, 1.05, 1.1],
            gyro_level: [0.9, 1.05, 1.0],
            ..hall
        };
        match self {
            Self::HallSlow => Character { speed: 0.6, flying_s: 112.0, rest_s: 12.0, ..hall },
            Self::HallCalm => Character {
                speed: 0.65,
                mix: Mix { circle: 0.6, line: 0.25, ..LINES },
                gyro_level: [0.95, 1.18, 1.0],
                ..hall
            },
            Self::HallFast => Character {
                speed: 1.2,
                yaw_rate: 0.35,
                flying_s: 95.0,
                mix: Mix { hover: 0.05, line: 0.55, circle: 0.1, eight: 0.3 },
                accel_level: [1.15, 1.0, 1.1],
                ..hall
            },
            Self::HallLoops => Character {
                speed: 1.15,
                flying_s: 75.0,
                mix: CURVES,
                accel_level: [0.99, 1.0, 0.97],
                gyro_level: [1.0, 1.05, 1.25],
                ..hall
            },
            Self::HallLines => Character {
                speed: 1.25,
                half_width: 8.0,
                flying_s: 85.0,
                rest_s: 5.0,
                mix: Mix { hover: 0.25, line: 0.75, circle: 0.0, eight: 0.0 },
                accel_level: [1.1, 0.98, 1.0],
                gyro_level: [1.0, 1.0, 1.1],
                ..hall
            },
            Self::RoomSlow => Character { speed: 0.5, yaw_rate: 0.4, flying_s: 110.0, ..room },
            Self::RoomMedium => Character {
                speed: 1.1,
                yaw_rate: 0.7,
                flying_s: 65.0,
                knot_s: 0.35,
                accel_level: [1.35, 1.05, 1.25],
                gyro_level: [0.95, 1.4, 1.15],
                ..room
            },
            Self::RoomAggressive => Character {
                speed: 1.3,
                yaw_rate: 0.95,
                flying_s: 80.0,
                knot_s: 0.3,
                correction: 0.01,
                yaw_correction: 0.06,
                mix: Mix { hover: 0.1, line: 0.5, circle: 0.2, eight: 0.2 },
                accel_level: [1.62, 1.07, 1.28],
                gyro_level: [1.0, 1.8, 1.25],
                ..room
            },
            Self::Hover => Character {
                speed: 0.35,
                yaw_rate: 0.3,
                flying_s: 60.0,
                rest_s: 15.0,
                idle_s: 8.0,
                mix: Mix { hover: 0.75, line: 0.25, circle: 0.0, eight: 0.0 },
                accel_level: [1.15, 1.4, 0.95],
                gyro_level: [1.5, 1.25, 1.0],
                ..room
            },
            Self::RoomSpiral => Character {
                speed: 0.95,
                yaw_rate: 0.9,
                flying_s: 85.0,
                knot_s: 0.35,
                mix: Mix { hover: 0.05, line: 0.1, circle: 0.85, eight: 0.0 },
                accel_level: [1.15, 1.2, 1.05],
                gyro_level: [1.15, 1.2, 1.05],
                ..room
            },
            Self::RoomWild => Character {
                speed: 1.35,
                yaw_rate: 0.9,
                flying_s: 80.0,
                knot_s: 0.3,
                correction: 0.01,
                yaw_correction: 0.06,
                mix: Mix { hover: 0.05, line: 0.25, circle: 0.2, eight: 0.5 },
                accel_level: [1.15, 1.17, 1.1],
                gyro_level: [1.2, 1.2, 1.12],
                ..room
            },
        }
    }
}
