"""Drives the demo as a ROS 2 node."""

import rclpy
from rclpy.action import ActionClient
from rclpy.node import Node

from demo.action import Goto
from demo.msg import State
from demo.srv import SetSpeed


class Driver(Node):
    def __init__(self):
        super().__init__("driver")
        self.last = None
        self.create_subscription(State, "demo/position", self.moved, 10)
        self.set_speed = self.create_client(SetSpeed, "demo/set_speed")
        self.goto = ActionClient(self, Goto, "demo/goto")

    def moved(self, state):
        self.last = state.position

    def result(self, future):
        rclpy.spin_until_future_complete(self, future)
        return future.result()


rclpy.init()
driver = Driver()

# An attribute is a service; so is a function.
driver.set_speed.wait_for_service()
reply = driver.result(driver.set_speed.call_async(SetSpeed.Request(velocity=1.0)))
print("set_speed:", reply.genom_exception or "done")
reply = driver.result(driver.set_speed.call_async(SetSpeed.Request(velocity=99.0)))
print("set_speed:", reply.genom_exception)

# An activity is an action.
driver.goto.wait_for_server()
goal = driver.result(driver.goto.send_goal_async(Goto.Goal(goal=0.25)))
ended = driver.result(goal.get_result_async())
print("goto:", ended.result.genom_exception or "done")

# A port is a topic.
while driver.last != 0.25:
    rclpy.spin_once(driver)
print("position:", driver.last)

rclpy.shutdown()
