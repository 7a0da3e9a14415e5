//! Levels that tune themselves, for another estimator's residuals.

use crate::border::Out;
use crate::status::{Fault, Status, call};
use crate::table::{LevelHandle, Table};
use dpn_core::Stamp;
use dpn_vio::components::Level;

struct Fed {
    level: Level,
    last: Option<Stamp>,
}

static LEVELS: Table<Fed> = Table::new("level");

/// Makes a level: the factor by which a deviation that was told is to be multiplied, 1 until residuals say otherwise. A residual counts for a third after
/// `memory_s` seconds; what is told counts at the start as `prior` residuals (10 s and 2 in dpn's own odometry).
///
/// # Safety
/// `level` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_level_new(memory_s: f64, prior: f64, level: *mut LevelHandle) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let out = unsafe { Out::new("level", level)? };
        let made = Level::new(memory_s, prior).ok_or_else(|| {
            Fault::bad(format!("`memory_s` is {memory_s}, `prior` {prior}; expected two numbers above 0"))
        })?;
        out.write(LEVELS.put(Fed { level: made, last: None }));
        Ok(())
    })
}

/// Feeds a residual of the time `t_ns` in ns: the sum of its squares, whitened with the deviation told times the level in force, and its redundancy: its
/// rows less what the states take up, tr(J H^-1 J^T) with the whitened Jacobian J and the states' covariance H^-1.
#[unsafe(no_mangle)]
pub extern "C" fn dpn_level_feed(level: LevelHandle, t_ns: i64, squares: f64, redundancy: f64) -> Status {
    call(|| {
        LEVELS.with(level, |fed| {
            let t = Stamp::from_ns(t_ns);
            let dt = fed.last.map_or(0.0, |last| t.seconds_since(last));
            if dt < 0.0 {
                return Err(Fault::bad(format!(
                    "`t_ns` is {t_ns}, {} s before the last; time must not go back",
                    -dt
                )));
            }
            if !fed.level.feed(dt, squares, redundancy) {
                let words = "expected two finite numbers from 0";
                return Err(Fault::bad(format!(
                    "`squares` is {squares}, `redundancy` {redundancy}; {words}"
                )));
            }
            fed.last = Some(t);
            Ok(())
        })
    })
}

/// Asks for the factor in force on the deviation told.
///
/// # Safety
/// `factor` is null or may be written to.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn dpn_level_factor(level: LevelHandle, factor: *mut f64) -> Status {
    call(|| {
        // SAFETY: as the caller promised.
        let out = unsafe { Out::new("factor", factor)? };
        out.write(LEVELS.with(level, |fed| Ok(fed.level.factor()))?);
        Ok(())
    })
}

/// Frees a level.
#[unsafe(no_mangle)]
pub extern "C" fn dpn_level_free(level: LevelHandle) -> Status {
    call(|| LEVELS.free(level))
}
