"""Codels of the demonstration component: they move one axis, one period at a time."""

from math import sqrt

from demo_types import HALTED, MOVING, OUT_OF_RANGE, ids, state

PERIOD = 0.005  # of task main, s
ACCELERATION = 2.0  # and deceleration, m/s2
SPEED = 0.5  # before the first set_speed, m/s
SPEEDS = (0.0, 2.0)  # that set_speed accepts, m/s
GOALS = (-10.0, 10.0)  # that goto accepts, m


def demo_init(ids: ids, position):
    """Permanent activity of task main, state start."""
    ids.velocity = SPEED
    ids.current = state(position=0.0, velocity=0.0)
    ids.halted = False
    position.write(ids.current)
    return "ether"


def demo_check_velocity(velocity: float):
    """Validation codel of attribute set_speed."""
    check(velocity, SPEEDS, "velocity, m/s")


def demo_check_goal(goal: float):
    """Validation codel of activity goto."""
    check(goal, GOALS, "goal, m")


def demo_reset(current: state):
    """Codel of function reset."""
    if current.velocity != 0.0:
        raise MOVING
    current.position = 0.0


def demo_begin(halted):
    """Activity goto, state start."""
    halted.value = False
    return "main"


def demo_servo(goal: float, velocity: float, halted: bool, current: state, parameter, position):
    """Activity goto, state main: one step towards the goal.

    The speed grows with the acceleration of the axis, and is such that the axis can still stop at
    the goal with it. The last step ends exactly there.
    """
    if halted:
        raise HALTED
    gain = parameter.latest()
    # 1 if the port was never written; 0 for negative gains and NaN.
    gain = 1.0 if gain is None else gain if gain > 0.0 else 0.0
    distance = goal - current.position
    sign = -1.0 if distance < 0.0 else 1.0
    speed = min(
        max(sign * current.velocity, 0.0) + ACCELERATION * PERIOD,
        velocity * gain,
        SPEEDS[1],
        sqrt(2.0 * ACCELERATION * abs(distance)),
    )
    arrived = abs(distance) <= speed * PERIOD
    if arrived:
        current.position, current.velocity = goal, 0.0
    else:
        current.position += sign * speed * PERIOD
        current.velocity = sign * speed
    position.write(current)
    return "ether" if arrived else "pause::main"


def demo_brake(current: state, position):
    """Activity goto, state stop: slows down until the axis stands still."""
    sign = -1.0 if current.velocity < 0.0 else 1.0
    speed = max(abs(current.velocity) - ACCELERATION * PERIOD, 0.0)
    current.position += sign * speed * PERIOD
    current.velocity = sign * speed if speed > 0.0 else 0.0
    position.write(current)
    return "pause::stop" if speed > 0.0 else "ether"


def demo_halt(current: state, halted, position):
    """Activity goto, event emergency: stops the axis at once.

    State main of the activity stays active besides: its codel sees `halted` and ends with HALTED.
    """
    current.velocity = 0.0
    halted.value = True
    position.write(current)
    return "ether"


def check(value: float, accepted: "tuple[float, float]", what: str) -> None:
    """Raises OUT_OF_RANGE for what is not accepted, also for NaN."""
    lower, upper = accepted
    if not lower <= value <= upper:
        raise OUT_OF_RANGE(value=value, lower=lower, upper=upper, what=what)
