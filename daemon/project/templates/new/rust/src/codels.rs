//! The codels of %NAME%.gen.

use genom::{Context, Event, Exception, OutPort, Thrown, event};

use crate::types::{Ids, OutOfRange, Place};

/// Seconds, as in the description.
const PERIOD: f64 = 0.01;
/// Metres per second.
const GREATEST: f64 = 2.0;

/// Validates the inputs of attribute set_speed.
#[genom::codel]
pub(crate) fn %NAME%_check_speed(speed: f64, context: &Context) -> Result<(), Thrown> {
    if speed > 0.0 && speed <= GREATEST {
        return Ok(());
    }
    Err(OutOfRange { greatest: GREATEST }.raise(context))
}

/// Task motion begins.
#[genom::codel]
pub(crate) fn %NAME%_begin(ids: &mut Ids) -> Event {
    *ids = Ids { position: 0.0, speed: 0.5 };
    event!("::%NAME%::shown")
}

/// Each period: what others read.
#[genom::codel]
pub(crate) fn %NAME%_show(
    position: f64,
    current: &mut OutPort<Place>,
    context: &Context,
) -> Result<Event, Thrown> {
    current.publish(Place { position }, context)?;
    Ok(event!("::%NAME%::pause::shown"))
}

/// Each period while moving.
#[genom::codel]
pub(crate) fn %NAME%_step(goal: f64, speed: f64, position: &mut f64) -> Event {
    let left = goal - *position;
    let step = speed * PERIOD;
    if left.abs() <= step {
        *position = goal;
        return event!("::%NAME%::ether");
    }
    *position += step.copysign(left);
    event!("::%NAME%::pause::start")
}

/// Interrupted: it stays where it is.
#[genom::codel]
pub(crate) fn %NAME%_halt() -> Event {
    event!("::%NAME%::ether")
}
