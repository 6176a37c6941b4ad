"""A node of ROS 2 that reads or writes images: `std_msgs/msg/UInt8MultiArray`.

`read TOPIC` says when the first one has come, and, whenever it is asked by a line, how many have come
since, once none has for a while, and its processor time so far in milliseconds. `write TOPIC BYTES
RATE COUNT` writes slowly until it is asked by a line, then COUNT images, and says how many they were, and
its processor time.
"""

import array
import sys
import threading
import time

import rclpy
from rclpy.qos import QoSProfile
from std_msgs.msg import UInt8MultiArray

# Images that either end keeps, as the ports of this benchmark.
QOS = QoSProfile(depth=8)

# Seconds without an image after which no more comes.
STRAGGLERS = 0.5


def say(*words):
    print(*words, flush=True)


def processor():
    return round(time.process_time() * 1000)


def read(node, topic):
    came = []

    def take(image):
        came.append(len(image.data))
        if len(came) == 1:
            say("connected")

    node.create_subscription(UInt8MultiArray, topic, take, QOS)
    threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()
    counted = 0
    for _ in sys.stdin:
        last = -1
        while last != len(came):
            last = len(came)
            time.sleep(STRAGGLERS)
        say(last - counted, processor())
        counted = last


def write(node, topic, size, rate, count):
    writer = node.create_publisher(UInt8MultiArray, topic, QOS)
    image = UInt8MultiArray(data=array.array("B", bytes(size)))
    asked = threading.Event()
    threading.Thread(target=lambda: (sys.stdin.readline(), asked.set()), daemon=True).start()
    while not asked.wait(0.05):
        writer.publish(image)
    # What was written before comes first.
    time.sleep(2 * STRAGGLERS)
    begun = time.monotonic()
    for number in range(count):
        time.sleep(max(0.0, begun + number / rate - time.monotonic()))
        writer.publish(image)
    say(count, processor())
    # What is on its way is repaired until the other end is done.
    sys.stdin.read()


def main():
    rclpy.init()
    node = rclpy.create_node("camera")
    verb, topic, *numbers = sys.argv[1:]
    if verb == "read":
        read(node, topic)
    else:
        write(node, topic, *map(int, numbers))


main()
