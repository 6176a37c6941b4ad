//! Codels of the control task: they validate requests.

use std::ops::RangeInclusive;

use genom::{BoundedString, Context, Exception, Thrown};

use crate::limits::{GOALS, SPEEDS};
use crate::types::{Moving, OutOfRange, State};

/// Validation codel of attribute `set_speed`.
#[genom::codel]
pub(crate) fn demo_check_velocity(velocity: f64, context: &Context) -> Result<(), Thrown> {
    check(velocity, &SPEEDS, "velocity, m/s", context)
}

/// Validation codel of activity `goto`.
#[genom::codel]
pub(crate) fn demo_check_goal(goal: f64, context: &Context) -> Result<(), Thrown> {
    check(goal, &GOALS, "goal, m", context)
}

/// Codel of function `reset`.
#[genom::codel]
pub(crate) fn demo_reset(current: &mut State, context: &Context) -> Result<(), Thrown> {
    if current.velocity != 0.0 {
        return Err(Moving.raise(context));
    }
    current.position = 0.0;
    Ok(())
}

fn check(
    value: f64,
    range: &RangeInclusive<f64>,
    what: &str,
    context: &Context,
) -> Result<(), Thrown> {
    if range.contains(&value) {
        return Ok(());
    }
    let what = BoundedString::new(what);
    Err(OutOfRange { value, lower: *range.start(), upper: *range.end(), what }.raise(context))
}
