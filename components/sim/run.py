"""Moves the simulated arm, as fast as the machine can: ``python3 components/sim/run.py``, in the
directory of genomd's sources, with the package genom. docs/simulators.md tells what it shows.
"""

import argparse
import contextlib

import genom
from film import Film

PERIOD = 0.01
EVERY = 40  # ms between images
POSTURES = [[0.5, 0.4, -0.8], [-0.5, 0.8, -1.2], [0.0, 0.0, 0.0]]


class Camera:
    """Films what a camera of the model sees."""

    def __init__(self, d, name: str) -> None:
        self._film, self._taken = Film(EVERY), 0
        d.component("sim").watch(camera=name, every=EVERY, ack=True)
        d.step(PERIOD)
        self._image = d.port(f"sim/image/{name}")

    def look(self) -> None:
        """Takes the image, if there is a new one."""
        if self._image.count > self._taken:
            self._taken = self._image.count
            self._film.take(self._image.data)

    def save(self, path: str) -> None:
        self._film.save(path)
        print(f"{len(self._film)} images in {path}")


def main() -> None:
    parser = argparse.ArgumentParser(description="Moves the simulated arm through three postures.")
    parser.add_argument("--config", default="configs/sim-arm.toml", help="the deployment")
    parser.add_argument("--film", metavar="FILE.png", help="write what the camera sees")
    parser.add_argument("--record", metavar="FILE.mcap", help="record all ports and calls")
    options = parser.parse_args()
    with genom.Daemon(config=options.config) as d, contextlib.ExitStack() as ends:
        d.deployed()
        recorder = None
        if options.record:
            recorder = ends.enter_context(d.record(options.record, force=True))
        planner, joints = d.component("planner"), d.port("sim/joints")
        hand = d.port("sim/sensors")
        camera = Camera(d, "front") if options.film else None
        print("   time   turn  shoulder  elbow      hand x, y, z")
        for goal in POSTURES:
            motion = planner.move(goal=goal, duration=1.0, ack=True)
            while motion.status == genom.Status.SENT:
                for _ in range(10):
                    d.step(PERIOD)
                    if camera:
                        camera.look()
                turn, shoulder, elbow = joints.data.position
                x, y, z = hand.data.value
                print(
                    f"{d.now:6.2f} s {turn:6.3f}  {shoulder:8.3f} {elbow:6.3f} rad"
                    f"  {x:6.3f} {y:6.3f} {z:6.3f} m"
                )
        if camera:
            camera.save(options.film)
        if recorder:
            print(recorder.close(), end="")
        print(f"{d.real_time_factor:.1f} seconds of the arm in a second of the machine")


if __name__ == "__main__":
    main()
