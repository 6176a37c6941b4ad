"""Codels of %NAME%: `%NAME%.gen` says when each is called, and with what."""

from %NAME%_types import e_out_of_range, ids

PERIOD = 0.01  # seconds, as in the description
GREATEST = 2.0  # metres per second


def %NAME%_check_speed(speed: float):
    """Validates the inputs of attribute set_speed."""
    if not 0.0 < speed <= GREATEST:
        raise e_out_of_range(greatest=GREATEST)


def %NAME%_begin(ids: ids):
    """Task motion begins."""
    ids.position = 0.0
    ids.speed = 0.5
    return "shown"


def %NAME%_show(position: float, current):
    """Each period: what others read."""
    current.data.position = position
    current.write()
    return "pause::shown"


def %NAME%_step(goal: float, speed: float, position):
    """Each period while moving."""
    left = goal - position.value
    step = speed * PERIOD
    if abs(left) <= step:
        position.value = goal
        return "ether"
    position.value += step if left > 0.0 else -step
    return "pause::start"


def %NAME%_halt():
    """Interrupted: it stays where it is."""
    return "ether"
