"""A ROS 2 node as rmw_zenoh_cpp makes it, on nothing but zenoh.

Keys, liveliness tokens, gids and attachments are written here as the design document of rmw_zenoh
has them; bodies are CDR in hexadecimal. Arguments: the endpoint of the router, and whether this
process is it. Commands and replies are JSON, one per line.
"""

import json
import queue
import struct
import sys
import time

import xxhash
import zenoh
from zenoh import ext

ROUTER, IS_ROUTER = sys.argv[1], sys.argv[2:] == ["router"]
PATIENCE = 50  # seconds; only a failing test waits this long


def session(mode, listen, connect):
    config = zenoh.Config()
    for key, value in {
        "mode": mode,
        "scouting/multicast/enabled": False,
        "listen/endpoints": listen,
        "connect/endpoints": connect,
        "timestamping/enabled": {"router": True, "peer": True, "client": True},
    }.items():
        config.insert_json5(key, json.dumps(value))
    return zenoh.open(config)


router = session("router", [ROUTER], []) if IS_ROUTER else None
node = session("peer", ["tcp/127.0.0.1:0"], [ROUTER])
zid = str(node.info.zid())
held, topics, written, counted, present, open_queries = [], {}, {}, [0], {}, {}


def seen(sample):
    key = str(sample.key_expr)
    if sample.kind == zenoh.SampleKind.PUT:
        present[key] = True
    else:
        present.pop(key, None)


held.append(node.liveliness().declare_subscriber("@ros2_lv/0/**", seen, history=True))
held.append(node.liveliness().declare_token(f"@ros2_lv/0/{zid}/0/0/NN/%/%/peer"))


def gid_of(token):
    return xxhash.xxh3_128_intdigest(token.encode()).to_bytes(16, "little")


def show(kind, name, ty, of, qos):
    """Declares the token of an end, and returns its gid."""
    counted[0] += 1
    mangled = name.replace("/", "%")
    token = f"@ros2_lv/0/{zid}/0/{counted[0]}/{kind}/%/%/peer/{mangled}/{ty}/{of}/{qos}"
    held.append(node.liveliness().declare_token(token))
    return gid_of(token)


def key_of(name, ty, of):
    return f"0/{name.strip('/')}/{ty}/{of}"


def attachment(number, gid):
    return ext.z_serialize((ext.Int64(number), ext.Int64(time.time_ns()), gid))


def fields(sample):
    """Body and attachment of a sample or reply."""
    raw = bytes(sample.attachment) if sample.attachment is not None else b""
    told = {"body": bytes(sample.payload).hex(), "size": len(raw)}
    if len(raw) == 33:
        number, stamp, length = struct.unpack("<qqB", raw[:17])
        recent = abs(time.time_ns() - stamp) < 3600 * 10**9
        told |= {"number": number, "recent": recent, "length": length, "gid": raw[17:].hex()}
    return told


def read(name, ty, of, latched):
    arrived = topics[name] = queue.Queue()
    key = key_of(name, ty, of)
    if latched:
        subscriber = ext.declare_advanced_subscriber(
            node,
            key,
            arrived.put,
            history=ext.HistoryConfig(detect_late_publishers=True, max_samples=1),
            recovery=ext.RecoveryConfig(periodic_queries=None, heartbeat=True),
            subscriber_detection=True,
        )
    else:
        subscriber = node.declare_subscriber(key, arrived.put)
    held.append(subscriber)
    show("MS", name, ty, of, ":1:,1:,:,:,," if latched else "::,7:,:,:,,")
    return "ready"


def sample(name):
    return fields(topics[name].get(timeout=PATIENCE))


def arrived(name):
    """Whether a sample waits."""
    return not topics[name].empty()


def write(name, ty, of, latched):
    key = key_of(name, ty, of)
    if latched:
        publisher = ext.declare_advanced_publisher(
            node,
            key,
            congestion_control=zenoh.CongestionControl.DROP,
            cache=ext.CacheConfig(max_samples=1),
            publisher_detection=True,
            sample_miss_detection=ext.MissDetectionConfig(sporadic_heartbeat=0.5),
        )
    else:
        publisher = node.declare_publisher(key)
    gid = show("MP", name, ty, of, ":1:,1:,:,:,," if latched else "::,7:,:,:,,")
    written[name] = [publisher, gid, 0]
    return gid.hex()


def matched(name):
    """Waits until somebody reads what is written."""
    end = time.monotonic() + PATIENCE
    while not written[name][0].matching_status.matching:
        if time.monotonic() > end:
            raise TimeoutError("nobody reads it")
        time.sleep(0.005)
    return "matched"


def put(name, body, skip=0):
    """Writes a sample, as if `skip` others before it were lost."""
    known = written[name]
    known[2] += 1 + skip
    known[0].put(bytes.fromhex(body), attachment=attachment(known[2], known[1]))
    return "done"


def buffers(name, body):
    """Writes a sample as nodes of Lyrical do whose message has a buffer: for each subscription of
    which the token says that it reads such, and for no other. How many there are."""
    known, mangled = written[name], name.replace("/", "%")
    there = [key for key in list(present) if "/MS/" in key and f"/{mangled}/" in key]
    aware = [key for key in there if key.endswith("/backends:cpu:")]
    known[2] += 1
    if aware:
        key = f"{known[0].key_expr}/_buf_cpu"
        node.put(key, bytes.fromhex(body), attachment=attachment(known[2], known[1]))
    return len(aware)


def plain(name, ty, of, body):
    """Writes a sample without attachment."""
    node.put(key_of(name, ty, of), bytes.fromhex(body))
    return "done"


def serve(name, ty, of, body):
    """Answers all requests with this body."""
    asked = topics[name] = queue.Queue()
    key = key_of(name, ty, of)

    def answer(query):
        number, _, _ = struct.unpack("<qqB", bytes(query.attachment)[:17])
        asked.put(query)
        gid = bytes(query.attachment)[17:]
        query.reply(key, bytes.fromhex(body), attachment=attachment(number, gid))

    held.append(node.declare_queryable(key, answer, complete=True))
    show("SS", name, ty, of, "::,10:,:,:,,")
    return "ready"


def hold(name, ty, of):
    """Takes requests, and answers none before it is told to."""
    asked = topics[name] = queue.Queue()
    held.append(node.declare_queryable(key_of(name, ty, of), asked.put, complete=True))
    show("SS", name, ty, of, "::,10:,:,:,,")
    return "ready"


def asked(name):
    """The next request: its body, for a later answer."""
    query = topics[name].get(timeout=PATIENCE)
    open_queries[name] = query
    return bytes(query.payload).hex()


def answer(name, body):
    """Answers the request that was asked last."""
    query = open_queries.pop(name)
    number, _, _ = struct.unpack("<qqB", bytes(query.attachment)[:17])
    gid = bytes(query.attachment)[17:]
    query.reply(query.key_expr, bytes.fromhex(body), attachment=attachment(number, gid))
    query.drop()
    return "done"


def client(name, ty, of):
    """Waits for a server of this name, type and hash."""
    key = key_of(name, ty, of)
    written[name] = [key, show("SC", name, ty, of, "::,10:,:,:,,"), 0]
    mangled, end = name.replace("/", "%"), time.monotonic() + PATIENCE
    while not any(f"/SS/" in key and f"/{mangled}/{ty}/{of}/" in key for key in list(present)):
        if time.monotonic() > end:
            raise TimeoutError(f"no server; there are {sorted(present)}")
        time.sleep(0.01)
    return "ready"


def call(name, body):
    known = written[name]
    known[2] += 1
    replies = node.get(
        known[0],
        payload=bytes.fromhex(body),
        attachment=attachment(known[2], known[1]),
        target=zenoh.QueryTarget.ALL_COMPLETE,
        consolidation=zenoh.ConsolidationMode.NONE,
        timeout=PATIENCE,
    )
    got = [reply for reply in replies]
    if len(got) != 1 or got[0].ok is None:
        return {"replies": len(got)}
    told = fields(got[0].ok)
    told["ours"] = told.get("number") == known[2] and told.get("gid") == known[1].hex()
    return told


def ends(text):
    """Keys of the present tokens that contain the text, with the gid of each."""
    return {key: gid_of(key).hex() for key in list(present) if text in key}


def gone(text):
    """Waits until no token contains the text."""
    end = time.monotonic() + PATIENCE
    while ends(text):
        if time.monotonic() > end:
            raise TimeoutError(f"still there: {sorted(ends(text))}")
        time.sleep(0.005)
    return "gone"


def there(text):
    """Waits until a token contains the text."""
    end = time.monotonic() + PATIENCE
    while not ends(text):
        if time.monotonic() > end:
            raise TimeoutError(f"there are only {sorted(present)}")
        time.sleep(0.005)
    return ends(text)


commands = {
    of.__name__: of
    for of in (
        *(read, sample, arrived, write, matched, put, buffers, plain),
        *(serve, hold, asked, answer, client, call, ends, gone, there),
    )
}
print('"up"', flush=True)
for line in sys.stdin:
    name, *rest = json.loads(line)
    print(json.dumps(commands[name](*rest)), flush=True)
