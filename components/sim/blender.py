"""The simulated arm in Blender, which is loaded as a module: ``python blender.py DIRECTORY``.

Steps the deployment, poses objects by what a port says, and renders an image of each 0.1 s. It wants
the packages bpy and genom in one interpreter. docs/simulators.md tells more.
"""

import math
import os
import sys

import bpy
import genom

PERIOD = 0.01
GOAL = [0.5, 0.4, -0.8]
# Name, parent, where its joint is in the parent, axis of the joint, length and radius: as arm.xml.
LINKS = [
    ("turn", None, 0.1, 2, 0.1, 0.08),
    ("shoulder", "turn", 0.15, 1, 0.4, 0.04),
    ("elbow", "shoulder", 0.4, 1, 0.35, 0.03),
]


def scene() -> list:
    """Makes the arm, a floor, a lamp and a camera. Returns the objects that joints turn."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    joints = {}
    for name, parent, at, _, length, radius in LINKS:
        joint = bpy.data.objects.new(name, None)
        bpy.context.collection.objects.link(joint)
        joint.parent = joints.get(parent)
        joint.location.z = at
        bpy.ops.mesh.primitive_cylinder_add(
            radius=radius, depth=length, location=(0, 0, length / 2)
        )
        bpy.context.object.parent = joint
        joints[name] = joint
    bpy.ops.mesh.primitive_plane_add(size=4)
    bpy.ops.object.light_add(type="SUN", rotation=(0.6, 0.4, 0))
    bpy.context.object.data.energy = 3
    bpy.ops.object.camera_add(location=(1.9, -1.5, 1.2), rotation=(1.3, 0, 0.9))
    bpy.context.scene.camera = bpy.context.object
    return [joints[link[0]] for link in LINKS]


def main() -> None:
    directory = sys.argv[1]
    objects = scene()
    render = bpy.context.scene.render
    # Needs neither a display nor a graphics card.
    render.engine = "CYCLES"
    bpy.context.scene.cycles.samples = 8
    render.resolution_x, render.resolution_y = 320, 240
    config = sys.argv[2] if len(sys.argv) > 2 else "configs/sim-arm.toml"
    with genom.Daemon(config=config) as d:
        d.deployed()
        joints = d.port("sim/joints")
        d.component("planner").move(goal=GOAL, duration=1.0, ack=True)
        for image in range(12):
            for _ in range(10):
                d.step(PERIOD)
            for object, link, angle in zip(objects, LINKS, joints.data.position):
                object.rotation_euler[link[3]] = angle
            render.filepath = os.path.abspath(os.path.join(directory, f"{image:03}.png"))
            bpy.ops.render.render(write_still=True)
        print("elbow at %.1f degrees" % math.degrees(joints.data.position[2]))


if __name__ == "__main__":
    main()
