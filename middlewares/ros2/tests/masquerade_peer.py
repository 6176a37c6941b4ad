"""A genuine ROS 2 node that calls services and runs actions of ROS's own types.

Each line in is a command, `["verb", arguments...]`, each line out its outcome.
"""

import json
import sys
import time
from importlib import import_module

import rclpy
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor

# Only what fails takes this long; the test's own watchdog is longer.
PATIENCE = 50.0

rclpy.init()
node = rclpy.create_node("caller", enable_rosout=False, start_parameter_services=False)
executor = SingleThreadedExecutor()
executor.add_node(node)
clients = {}


def until(what, holds):
    end = time.monotonic() + PATIENCE
    while not (held := holds()):
        if time.monotonic() > end:
            raise TimeoutError(f"never: {what}")
        executor.spin_once(timeout_sec=0.02)
    return held


def done(future):
    until("the reply", future.done)
    return future.result()


def type_of(name):
    package, folder, name = name.split("/")
    return getattr(import_module(f"{package}.{folder}"), name)


def plain(message):
    fields = message.get_fields_and_field_types()
    value = {name: getattr(message, name) for name in fields}
    return {
        name: one if isinstance(one, (bool, int, float, str)) else list(one)
        for name, one in value.items()
    }


def call(service, kind, values):
    if service not in clients:
        clients[service] = node.create_client(type_of(kind), service)
        until(service, clients[service].service_is_ready)
    return plain(done(clients[service].call_async(type_of(kind).Request(**values))))


def goal(action, kind, values, cancel):
    if action not in clients:
        clients[action] = ActionClient(node, type_of(kind), action)
        until(action, clients[action].server_is_ready)
    handle = done(clients[action].send_goal_async(type_of(kind).Goal(**values)))
    if not handle.accepted:
        return "refused"
    if cancel:
        canceling = done(handle.cancel_goal_async()).goals_canceling
        assert len(canceling) == 1, canceling
    reply = done(handle.get_result_async())
    return [reply.status, plain(reply.result)]


VERBS = {"call": call, "goal": goal}

print(json.dumps("up"), flush=True)
for line in sys.stdin:
    verb, *arguments = json.loads(line)
    print(json.dumps(VERBS[verb](*arguments)), flush=True)
rclpy.shutdown()
