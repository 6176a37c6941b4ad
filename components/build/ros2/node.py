"""A genuine ROS 2 node, controlled line by line.

Each input line is a command, `["verb", arguments...]`; each output line is its result. A verb that
creates an endpoint replies when ROS reports a matching endpoint, so that the test may rely on it;
what it serves, and latched writers, are there for those that come later. Between two commands the
node answers requests.
"""

import json
import queue
import sys
import threading
import time
from array import array
from collections import deque
from importlib import import_module

import numpy
import rclpy
from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient, ActionServer, CancelResponse
from rclpy.event_handler import PublisherEventCallbacks, SubscriptionEventCallbacks
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import NodeNameNonExistentError
from rclpy.parameter import Parameter, parameter_value_to_python
from rclpy.parameter_client import AsyncParameterClient
from rclpy.qos import QoSDurabilityPolicy, QoSProfile
from rclpy.task import Future

# Only a failing test takes this long; its own watchdog waits longer.
PATIENCE = 50.0

rclpy.init()
node = rclpy.create_node("peer", enable_rosout=False, start_parameter_services=False)
executor = SingleThreadedExecutor()
executor.add_node(node)


def until(what, holds):
    """Spins the node until the condition holds."""
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


def plain(value):
    """Converts a message to JSON."""
    if hasattr(value, "get_fields_and_field_types"):
        return {name: plain(getattr(value, name)) for name in value.get_fields_and_field_types()}
    if isinstance(value, (list, tuple, array, numpy.ndarray)):
        return [plain(element) for element in value]
    if isinstance(value, bytes):
        return value[0]
    return value.item() if isinstance(value, numpy.generic) else value


def fill(message, values):
    """Sets fields of a message from JSON."""
    for name, value in values.items():
        if isinstance(value, dict):
            fill(getattr(message, name), value)
        elif isinstance(value, list) and value and isinstance(value[0], dict):
            # `sequence<package/Name>`
            package, kind = message.get_fields_and_field_types()[name][9:-1].split("/")
            element = type_of(f"{package}/msg/{kind}")
            setattr(message, name, [fill(element(), one) for one in value])
        else:
            setattr(message, name, value)
    return message


class Matched:
    """Counts the endpoints of others that match an endpoint of this node."""

    count = 0

    def __call__(self, status):
        self.count = status.current_count


readers, writers, clients, actions, goals, served = {}, {}, {}, {}, {}, {}


def read(topic, kind, least=1, latched=False):
    """Replies when there are so many publishers. With `latched`, it gets what they published last."""
    matched, samples = Matched(), deque()
    events = SubscriptionEventCallbacks(matched=matched)
    quality = QoSProfile(depth=10)
    if latched:
        quality.durability = QoSDurabilityPolicy.TRANSIENT_LOCAL
    node.create_subscription(type_of(kind), topic, lambda sample: samples.append(sample), quality, event_callbacks=events)
    readers[topic] = samples
    until(f"{least} publishers of {topic}", lambda: matched.count >= least)
    return "matched"


def sample(topic):
    until(f"a sample of {topic}", lambda: readers[topic])
    return plain(readers[topic].popleft())


def digest(topic):
    """How many bytes the next sample has, an array of them, and the sum of each times its place."""
    until(f"a sample of {topic}", lambda: readers[topic])
    data = numpy.frombuffer(readers[topic].popleft().data, numpy.uint8).astype(numpy.uint64)
    return [len(data), int(data @ numpy.arange(len(data), dtype=numpy.uint64))]


def write(topic, kind, latched=False):
    """Replies when there is a subscription. With `latched`, at once: whoever comes gets the last."""
    matched = Matched()
    events = PublisherEventCallbacks(matched=matched)
    quality = QoSProfile(depth=10)
    if latched:
        quality = QoSProfile(depth=1, durability=QoSDurabilityPolicy.TRANSIENT_LOCAL)
    writers[topic] = node.create_publisher(type_of(kind), topic, quality, event_callbacks=events)
    until(f"a subscription of {topic}", lambda: latched or matched.count)
    return "matched"


def put(topic, values):
    writers[topic].publish(fill(writers[topic].msg_type(), values))
    return "put"


def close(topic):
    """Ends what this node writes."""
    node.destroy_publisher(writers.pop(topic))
    return "closed"


def nodes():
    return sorted(f"{namespace.rstrip('/')}/{name}" for name, namespace in node.get_node_names_and_namespaces())


def no_node(name, namespace):
    nodes = node.get_node_names_and_namespaces
    until(f"the end of the node {name}", lambda: (name, namespace) not in nodes())
    return "gone"


def services_of(name, namespace):
    try:
        return dict(node.get_service_names_and_types_by_node(name, namespace))
    except NodeNameNonExistentError:
        return {}


def service(service, name, namespace):
    return until(f"{service} of {name}", lambda: services_of(name, namespace).get(service))


def no_service(service, name, namespace):
    until(f"the end of {service}", lambda: service not in services_of(name, namespace))
    return "gone"


def no_writer(topic):
    until(f"the end of the publishers of {topic}", lambda: not node.count_publishers(topic))
    return "gone"


def topics():
    return dict(node.get_topic_names_and_types())


def parameters(of):
    clients[of] = AsyncParameterClient(node, of)
    until(f"the parameter services of {of}", clients[of].services_are_ready)
    return "ready"


def get(of, names):
    values = done(clients[of].get_parameters(names)).values
    return [plain(parameter_value_to_python(value)) for value in values]


def types(of, names):
    return [Parameter.Type(kind).name for kind in done(clients[of].get_parameter_types(names)).types]


def put_all(of, values, atomically=False):
    given = [Parameter(name, value=value) for name, value in values]
    if atomically:
        return plain(done(clients[of].set_parameters_atomically(given)).result)
    return plain(done(clients[of].set_parameters(given)).results)


def describe(of, names):
    return plain(done(clients[of].describe_parameters(names)).descriptors)


def names(of, prefixes=None, depth=None):
    return plain(done(clients[of].list_parameters(prefixes, depth)).result)


def client(service, kind):
    # As many replies as a test asks for at once: unless told so, a client keeps the last ten that came
    # since it was looked at, and loses those before.
    clients[service] = node.create_client(type_of(kind), service, qos_profile=QoSProfile(depth=100))
    until(f"the service {service}", clients[service].service_is_ready)
    return "ready"


def call(service, values):
    made = clients[service]
    return plain(done(made.call_async(fill(made.srv_type.Request(), values))))


def burst(service, count, values):
    """Calls many times at once. Returns the replies that there are when one of them is a success."""
    made = clients[service]
    calls = [made.call_async(fill(made.srv_type.Request(), values)) for _ in range(count)]
    replies = lambda: [plain(call.result()) for call in calls if call.done()]
    try:
        until("a success", lambda: any(reply["success"] for reply in replies()))
    except TimeoutError as error:
        raise TimeoutError(f"{error}; the replies: {replies()}") from None
    return replies()


def action(name, kind):
    actions[name] = ActionClient(node, type_of(kind), name)
    until(f"the action {name}", actions[name].server_is_ready)
    return "ready"


def goal(action, values):
    """Sends a goal. Returns whether it was accepted."""
    fed, kind = deque(), actions[action]._action_type
    sent = actions[action].send_goal_async(
        fill(kind.Goal(), values), feedback_callback=lambda message: fed.append(message.feedback)
    )
    handle = done(sent)
    goals[action] = handle, fed, handle.get_result_async() if handle.accepted else None
    return handle.accepted


def feedback(action):
    fed = goals[action][1]
    until(f"feedback of {action}", lambda: fed)
    return plain(fed.popleft())


def status(action, wanted):
    """Waits until the status topic reports this status for the goal."""
    handle = goals[action][0]
    until(f"status {wanted}", lambda: handle.status == getattr(GoalStatus, f"STATUS_{wanted}"))
    return wanted


def cancel(action):
    reply = done(goals[action][0].cancel_goal_async())
    return {"code": reply.return_code, "goals": len(reply.goals_canceling)}


def result(action):
    ended = done(goals[action][2])
    names = [name for name in dir(GoalStatus) if name.startswith("STATUS_")]
    name = next(name for name in names if getattr(GoalStatus, name) == ended.status)
    return {"status": name.removeprefix("STATUS_"), "result": plain(ended.result)}


def serve(service, kind, replies):
    """Answers requests with these, one after the other, and then again with the last one."""
    asked, replies = deque(), deque(replies)

    def answer(request, response):
        asked.append(plain(request))
        return fill(response, replies.popleft() if len(replies) > 1 else replies[0])

    served[service] = asked, node.create_service(type_of(kind), service, answer)
    return "serves"


def asked(service):
    """The next request to a service, or goal of an action, that this node serves."""
    until(f"a request to {service}", lambda: served[service][0])
    return served[service][0].popleft()


def serve_action(action, kind):
    """Accepts each goal. It runs until `end`, whatever its client wants."""
    asked, running = deque(), deque()

    async def run(goal):
        running.append((goal, Future()))
        asked.append(plain(goal.request))
        return await running[-1][1]

    server = ActionServer(
        node, type_of(kind), action, run, cancel_callback=lambda _: CancelResponse.ACCEPT
    )
    served[action] = asked, server, running
    return "serves"


def feed(action, values):
    """Tells the client of the goal that runs something, as soon as it listens."""
    goal, _ = served[action][2][0]
    until(f"a reader of {action}", lambda: node.count_subscribers(f"{action}/_action/feedback"))
    goal.publish_feedback(fill(served[action][1].action_type.Feedback(), values))
    return "told"


def to_cancel(action):
    """Waits until the client of the goal that runs wants to cancel it."""
    until(f"a wish to cancel {action}", lambda: served[action][2][0][0].is_cancel_requested)
    return "to cancel"


def end(action, how, values):
    """Ends the goal that runs: `succeed`, `abort` or `canceled`."""
    goal, ended = served[action][2].popleft()
    getattr(goal, how)()
    ended.set_result(fill(served[action][1].action_type.Result(), values))
    return how


VERBS = {
    "client": client,
    "call": call,
    "burst": burst,
    "action": action,
    "goal": goal,
    "feedback": feedback,
    "status": status,
    "cancel": cancel,
    "result": result,
    "serve": serve,
    "asked": asked,
    "serve action": serve_action,
    "feed": feed,
    "to cancel": to_cancel,
    "end": end,
    "read": read,
    "sample": sample,
    "digest": digest,
    "write": write,
    "put": put,
    "close": close,
    "nodes": nodes,
    "no node": no_node,
    "service": service,
    "no service": no_service,
    "no writer": no_writer,
    "topics": topics,
    "parameters": parameters,
    "get": get,
    "set": put_all,
    "types": types,
    "describe": describe,
    "list": names,
}

commands, bell = queue.SimpleQueue(), node.create_guard_condition(lambda: None)


def listen():
    """Hands over the commands, and `None` at their end."""
    for line in sys.stdin:
        commands.put(line)
        bell.trigger()
    commands.put(None)
    bell.trigger()


threading.Thread(target=listen, daemon=True).start()
print(json.dumps("up"), flush=True)
while True:
    while commands.empty():
        executor.spin_once()
    if (line := commands.get()) is None:
        break
    verb, *arguments = json.loads(line)
    print(json.dumps(VERBS[verb](*arguments)), flush=True)
rclpy.shutdown()
