#!/usr/bin/env python3
"""A user's control law: separates the boosters. own_control.py SCENARIO"""
import sys

import unlatch

SEQUENCE = {100: ("throttle", 0.84), 250: ("verniers", 0), 300: ("rudder", 0), 450: ("cut_ties", 1), 500: ("cutoff", 1)}  # tick, ms

with unlatch.load(sys.argv[1]) as sim:
    contact = {}  # tick at which a booster's contact fired
    while sim.tick < 2000:
        tick = sim.tick
        name, value = SEQUENCE.get(tick, ("", 0))
        for channel in sim.channels:
            if name and channel.rstrip("1234") == name:
                sim.channels[channel] = value
        for i in "1234":
            if i not in contact and sim.sensors[f"kr{i}"][0] > 0.5:
                contact[i] = tick
            if tick == contact.get(i, tick) + 12:  # the nozzle pushes the nose away 12 ms later
                sim.channels[f"nozzle{i}"] = 1
        sim.step()
    for event in sim.events:
        print(f"{event.time:.6f} s  {event.name} {event.subject}")
    print("hash", sim.hash)
