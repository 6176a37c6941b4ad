"""Feeds an in port, and follows an out port."""

import genom

g = genom.connect()
demo = g.load("demo")

with demo.parameter.publisher() as gain:      # feeds in port `parameter` from here
    gain(0.5)                                 # half of the speed
    motion = demo.goto(goal=0.1, ack=True)    # returns when it is accepted
    with demo.position.subscribe() as positions:
        for state in positions:               # each value as it comes
            if state["position"] == 0.1:
                break
    motion.wait(timeout=30)
print("there:", demo.get_position())
