#!/usr/bin/env python3
"""Records and replays an hour at 1 kHz with 64 bodies, and a shorter run of five bodies, and prints time and memory. Run by hand:

    long_recording.py BIN_FOLDER SOURCE_FOLDER [HOURS]
"""

import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path

UNLATCH, SOURCE = Path(sys.argv[1]) / "unlatch", Path(sys.argv[2])
HOURS = float(sys.argv[3]) if len(sys.argv) > 3 else 1.0
ARMS, LINKS = 3, 21  # 1 + 3 * 21 = 64 bodies
FIVE_BODIES_S = 300


def build_scenario():
    """A hub with three arms of links on damped springs, one of them driven all the time; each arm releases its last link."""
    bodies = ["  hub: {mass: 500, inertia: [300, 300, 300]}"]
    joints, springs, events = [], [], []
    for arm in range(ARMS):
        inner = "hub"
        for link in range(LINKS):
            name = f"a{arm}l{link}"
            bodies.append(f"  {name}: {{mass: {5 + link % 3}, inertia: [1, 2, 3], position: [{link + 1}, {2 * arm}, 0]}}")
            point = f"[0.5, {2 * arm if inner == 'hub' else 0}, 0]"
            joints.append(f"  j{name}:\n    between: [{inner}, {name}]\n    point: {point}\n    follower_point: [-0.5, 0, 0]\n"
                          f"    modes: {{held: {{kind: revolute, axis: {'yz'[link % 2]}}}, free: {{rows: []}}}}\n    mode: held")
            springs.append(f"  s{name}: {{type: joint_spring, joint: j{name}, axis: rot_{'yz'[link % 2]}, stiffness: 900, damping: 12}}")
            inner = name
        events.append(f"  - {{name: leave, subject: {inner}, when: {{time: {100 * (arm + 1)}.0003}}, "
                      f"then: [{{set_mode: {{joint: j{inner}, mode: free}}}}]}}")
    push = "  push: {type: torque, body: a0l10, direction: [0, 0, 1], profile: {harmonic: [{amplitude: 4, frequency: 1.7, phase: 0}]}}"
    return "\n".join(["unlatch: 1", "name: long", "step: {dt: 0.001, until: 1}", "bodies:", *bodies, "joints:", *joints,
                      "elements:", *springs, push, "events:", *events, ""])


def measure(*arguments):
    """Returns wall time in s and peak memory in bytes of a process."""
    begin = time.monotonic()
    process = subprocess.Popen(list(map(str, arguments)), stdout=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    if status != 0:
        sys.exit(f"{arguments[1]} ended with status {status}")
    return time.monotonic() - begin, usage.ru_maxrss * 1024


def record_and_replay(title, scenario, seconds, folder):
    log = folder / "long.log"
    print(f"{title}, {seconds:g} s at 1 kHz", flush=True)
    for what, arguments in (("recorded", ["run", scenario, "--until", seconds, "--log", log]), ("replayed", ["replay", log])):
        took, peak = measure(UNLATCH, *arguments)
        print(f"  {what} in {took:.1f} s, {seconds / took:.0f} times real time, peak memory {peak / 2**20:.1f} MiB", flush=True)
    size = log.stat().st_size
    print(f"  {size / 1e6:.0f} MB, {size / (1000 * seconds):.0f} bytes a tick")
    log.unlink()


with tempfile.TemporaryDirectory(prefix="unlatch_long_") as name:
    folder = Path(name)
    scenario = folder / "long.yaml"
    scenario.write_text(build_scenario())
    record_and_replay("64 bodies", scenario, round(3600 * HOURS, 3), folder)
    record_and_replay("5 bodies", SOURCE / "hil/scenarios/boosters/reference.yaml", FIVE_BODIES_S, folder)
