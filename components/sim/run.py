"""Moves the simulated arm, as fast as the machine can: ``python3 components/sim/run.py``, in the
directory of genomd's sources, with the package genom. docs/simulators.md tells what it shows.
"""

import genom

PERIOD = 0.01
POSTURES = [[0.5, 0.4, -0.8], [-0.5, 0.8, -1.2], [0.0, 0.0, 0.0]]


def main() -> None:
    with genom.Daemon(config="configs/sim-arm.toml") as d:
        d.deployed()
        planner, joints = d.component("planner"), d.port("sim/joints")
        hand = d.port("sim/sensors")
        print("   time   turn  shoulder  elbow      hand x, y, z")
        for goal in POSTURES:
            motion = planner.move(goal=goal, duration=1.0, ack=True)
            while motion.status == genom.Status.SENT:
                for _ in range(10):
                    d.step(PERIOD)
                turn, shoulder, elbow = joints.data.position
                x, y, z = hand.data.value
                print(
                    f"{d.now:6.2f} s {turn:6.3f}  {shoulder:8.3f} {elbow:6.3f} rad"
                    f"  {x:6.3f} {y:6.3f} {z:6.3f} m"
                )
        print(f"{d.real_time_factor:.1f} seconds of the arm in a second of the machine")


if __name__ == "__main__":
    main()
