"""Moves the demo, and reads where it is."""

import genom

g = genom.connect()                 # the genomd of this user
demo = g.load("demo")               # the component that runs there
demo.set_speed(velocity=0.5)
demo.goto(goal=0.3)                 # returns when the axis is there
print("at", demo.position.read()["position"])

try:
    demo.goto(goal=1000.0)
except demo.OUT_OF_RANGE as error:  # an exception of the component
    print("refused: at most", error.detail["upper"])
