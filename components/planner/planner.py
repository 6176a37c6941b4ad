"""Codels of planner."""

import math

from planner_types import NO_MOTION

PERIOD = 0.01


def planner_init(ids):
    ids.here.clear()
    return "ether"


def planner_begin(goal, duration, here, from_, elapsed):
    if not all(map(math.isfinite, [*goal, duration])) or duration <= 0.0:
        raise NO_MOTION(why="finite numbers are needed, and a duration above 0")
    known = list(here)[: len(goal)]
    # Joints of which nothing was said before are at 0.
    from_.clear()
    from_.extend(known + [0.0] * (len(goal) - len(known)))
    elapsed.value = 0.0
    return "main"


def planner_step(goal, duration, from_, elapsed, here, target):
    elapsed.value += PERIOD
    part = min(elapsed.value / duration, 1.0)
    way = part**3 * (10 - 15 * part + 6 * part**2)
    speed = 30 * part**2 * (1 - part) ** 2 / duration
    here.clear()
    here.extend(a + (b - a) * way for a, b in zip(from_, goal))
    data = target.data
    data.position = list(here)
    data.velocity = [(b - a) * speed for a, b in zip(from_, goal)]
    target.write()
    return "ether" if part == 1.0 else "pause::main"


def planner_rest():
    return "ether"
