//! Codels of task `main`: they move the axis, one period at a time.

use genom::{Bool, Context, Event, Exception, InPort, OutPort, Thrown, event};

use crate::limits::{ACCELERATION, PERIOD, SPEED, SPEEDS};
use crate::types::{Gain, Halted, Ids, State};

const ETHER: Event = event!("::demo::ether");
const MAIN: Event = event!("::demo::main");
const PAUSE_MAIN: Event = event!("::demo::pause::main");
const PAUSE_STOP: Event = event!("::demo::pause::stop");

/// Permanent activity of task `main`, state `start`.
#[genom::codel]
pub(crate) fn demo_init(
    ids: &mut Ids,
    position: &mut OutPort<State>,
    context: &Context,
) -> Result<Event, Thrown> {
    *ids = Ids {
        velocity: SPEED,
        current: State { position: 0.0, velocity: 0.0 },
        halted: false.into(),
    };
    position.publish(ids.current, context)?;
    Ok(ETHER)
}

/// Activity `goto`, state `start`.
#[genom::codel]
pub(crate) fn demo_begin(halted: &mut Bool) -> Event {
    halted.set(false);
    MAIN
}

/// Activity `goto`, state `main`: one step towards the goal.
///
/// The speed is limited by the acceleration of the axis and such that it can still stop at the
/// goal. The last step ends exactly there.
#[genom::codel]
pub(crate) fn demo_servo(
    goal: f64,
    velocity: f64,
    halted: bool,
    current: &mut State,
    parameter: &mut InPort<Gain>,
    position: &mut OutPort<State>,
    context: &Context,
) -> Result<Event, Thrown> {
    if halted {
        return Err(Halted.raise(context));
    }
    // 1 if the port was never written; 0 for negative gains and NaN.
    let gain = parameter.latest(context).map_or(1.0, |gain| gain.max(0.0));
    let distance = goal - current.position;
    let sign = if distance < 0.0 { -1.0 } else { 1.0 };
    let speed = ((sign * current.velocity).max(0.0) + ACCELERATION * PERIOD)
        .min(velocity * gain)
        .min(*SPEEDS.end())
        .min((2.0 * ACCELERATION * distance.abs()).sqrt());

    let arrived = distance.abs() <= speed * PERIOD;
    *current = if arrived {
        State { position: goal, velocity: 0.0 }
    } else {
        State { position: current.position + sign * speed * PERIOD, velocity: sign * speed }
    };
    position.publish(*current, context)?;
    Ok(if arrived { ETHER } else { PAUSE_MAIN })
}

/// Activity `goto`, state `stop`: slows down until the axis stands still.
#[genom::codel]
pub(crate) fn demo_brake(
    current: &mut State,
    position: &mut OutPort<State>,
    context: &Context,
) -> Result<Event, Thrown> {
    let sign = if current.velocity < 0.0 { -1.0 } else { 1.0 };
    let speed = (current.velocity.abs() - ACCELERATION * PERIOD).max(0.0);

    current.position += sign * speed * PERIOD;
    current.velocity = if speed > 0.0 { sign * speed } else { 0.0 };
    position.publish(*current, context)?;
    Ok(if speed > 0.0 { PAUSE_STOP } else { ETHER })
}

/// Activity `goto`, external event `emergency`: stops the axis at once.
///
/// State `main` of the activity stays active besides: its codel sees `halted` and ends with
/// `HALTED`.
#[genom::codel]
pub(crate) fn demo_halt(
    current: &mut State,
    halted: &mut Bool,
    position: &mut OutPort<State>,
    context: &Context,
) -> Result<Event, Thrown> {
    current.velocity = 0.0;
    halted.set(true);
    position.publish(*current, context)?;
    Ok(ETHER)
}
