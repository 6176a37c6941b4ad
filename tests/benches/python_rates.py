#!/usr/bin/env python3
"""Performance of ports in the Python client: round trips per second, and a loop at 1 kHz.

    cargo build --release -p genomd
    pip install iceoryx2==0.10.0 eclipse-zenoh==1.10.2
    tests/benches/python_rates.py target/release target/components/demo/demo.so [STEPS]

Runs the client's measuring tests (clients/python/tests) against a release build of the daemon:
round trips over zenoh, compared with bare zenoh; round trips over shared memory; and late steps
with the p50 and p99 of a step's period, compared with a loop without ports. Default: 10,000 STEPS.
"""

import os
import subprocess
import sys
import tempfile

PACKAGE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../clients/python")
CASES = {
    "zenoh": ["test_zenoh.Zenoh.test_samples_go_to_another_process_and_come_back_in_order"],
    "shm": [
        "test_shared_memory.SharedMemory.test_samples_go_to_another_process_and_come_back_in_order",
        "test_shared_memory.SharedMemory.test_a_simulator_gets_the_command_to_each_state_in_each_step",
    ],
}


def measure(genomd: str, library: str, backend: str, steps: str) -> None:
    with tempfile.TemporaryDirectory() as scratch:
        socket = os.path.join(scratch, "genomd.sock")
        own = ["--set", f"backends.shm.root={scratch}", "--set", f"backends.zenoh.rendezvous={scratch}/z"]
        arguments = [genomd, "--socket", socket, "--backend", backend, *own]
        daemon = subprocess.Popen(arguments, stderr=subprocess.PIPE, text=True)
        assert daemon.stderr is not None
        for line in daemon.stderr:
            if "ready on" in line:
                break
        environment = {
            **os.environ,
            "PYTHONPATH": os.path.join(PACKAGE, "src"),
            "GENOMD_SOCKET": socket,
            "GENOM_DEMO": library,
            "GENOM_STEPS": steps,
        }
        try:
            for case in CASES[backend]:
                command = [sys.executable, "-m", "unittest", f"tests.{case}"]
                told = subprocess.run(command, cwd=PACKAGE, env=environment, stderr=subprocess.PIPE, text=True)
                lines = told.stderr.splitlines()
                print("\n".join(line.lstrip(".") for line in lines if "round trips" in line or "1 kHz" in line))
                if told.returncode != 0:
                    sys.exit(told.stderr)
        finally:
            daemon.terminate()
            daemon.communicate()


def main() -> None:
    directory, library = os.path.abspath(sys.argv[1]), os.path.abspath(sys.argv[2])
    steps = sys.argv[3] if len(sys.argv) > 3 else "10000"
    for backend in CASES:
        measure(os.path.join(directory, "genomd"), library, backend, steps)
    print("load:", *(f"{load:.1f}" for load in os.getloadavg()))


if __name__ == "__main__":
    main()
