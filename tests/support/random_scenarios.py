"""Random scenarios and fault scripts that are valid, and moderate enough to be stepped to their end. The same seed gives the same text."""

import json
import math
import random

MODES = {
    "hinge": {"kind": "revolute", "axis": "z"}, "ball": {"kind": "ball"}, "cross": {"kind": "universal"},
    "slider": {"kind": "prismatic", "axis": "x"}, "sleeve": {"kind": "cylindrical", "axis": "y"},
    "plane": {"kind": "planar", "axis": "z"}, "weld": {"kind": "weld"}, "free": {"rows": []},
    "odd": {"rows": ["x", "rot_y"]},
}
MOST_FREQUENCY = 50.0  # rad/s, limit for any spring: well resolved by a step of 2 ms


def draw_vector(draw, size):
    return [round(draw.uniform(-size, size), 3) for _ in range(3)]


def draw_body(draw):
    """Draws a box of some density: its inertia keeps the triangle inequality."""
    mass = round(10 ** draw.uniform(0, 4), 3)
    a, b, c = (draw.uniform(0.5, 3) for _ in range(3))
    return {"mass": mass, "inertia": [round(mass / 12 * (x * x + y * y), 6) for x, y in ((b, c), (a, c), (a, b))]}


def draw_shape(draw, hollow):
    """Draws a shape of about half a metre near the body's origin, perhaps a hollow one: two of these have no distance."""
    centre, radius = draw_vector(draw, 0.5), round(draw.uniform(0.05, 0.4), 3)
    end = [round(c + e, 3) for c, e in zip(centre, draw_vector(draw, 0.4)[:2] + [0.5])]
    if hollow and draw.random() < 0.3:
        return {"hollow_cylinder": {"from": centre, "to": end, "radius": radius}}
    return draw.choice(({"sphere": {"centre": centre, "radius": radius}}, {"capsule": {"from": centre, "to": end, "radius": radius}},
                        {"cylinder": {"from": centre, "to": end, "radius": radius}}, {"cone": {"from": centre, "to": end, "radius": radius}},
                        {"box": {"centre": centre, "size": [radius, round(2 * radius, 3), 0.3]}}))


def draw_profile(draw, size):
    kind = draw.randrange(4)
    if kind == 0:
        return round(size, 3)
    if kind == 1:
        return {"exponential": {"initial": round(size, 3), "final": 0, "tau": round(draw.uniform(0.05, 1), 3)}}
    if kind == 2:
        return {"table": {"times": [0, 0.1, 0.25, 0.6], "values": [0, round(size, 3), round(-size / 2, 3), 0]}}
    return {"harmonic": [{"amplitude": round(size / (1 + i), 3), "frequency": round(draw.uniform(1, 40), 3), "phase": 0.1 * i}
                         for i in range(draw.randint(1, 3))]}


class ScenarioDraw:
    def __init__(self, seed):
        self.draw = random.Random(seed)
        self.scenario = {"unlatch": 1, "name": f"random{seed}", "step": {"dt": self.draw.choice((0.0005, 0.001, 0.002)),
                                                                       "until": self.draw.choice((0.4, 0.8, 1.2))}}
        self.watched = []  # pairs with a clearance
        self.names = [f"b{i}" for i in range(self.draw.randint(1, 12))]

    def build(self):
        draw, scenario = self.draw, self.scenario
        if draw.random() < 0.7:
            scenario["gravity"] = {"uniform": draw_vector(draw, 9.81)}
        self.add_tree()
        scenario["channels"] = {f"c{i}": {"initial": 0.5, "range": [0, 1], "safe": 0.25} for i in range(draw.randint(0, 2))}
        self.add_shapes()
        self.add_elements()
        self.add_sensors()
        self.add_events()
        self.add_rigid()
        if scenario["sensors"] and draw.random() < 0.3:
            scenario["timing"] = {"groups": {"slow": {"every": draw.randint(2, 5), "sensors": [draw.choice(list(scenario["sensors"]))]}}}
        return scenario

    def add_tree(self):
        """Joins every body but the first to an earlier one, placed so that the joint's two points coincide."""
        draw = self.draw
        bodies, joints = self.scenario.setdefault("bodies", {}), self.scenario.setdefault("joints", {})
        for i, name in enumerate(self.names):
            body = bodies[name] = draw_body(draw)
            if i == 0 and draw.random() < 0.5:
                body["velocity"], body["rate"] = draw_vector(draw, 2), draw_vector(draw, 0.5)
                continue
            base = "ground" if i == 0 else draw.choice(self.names[:i])
            point, follower_point = draw_vector(draw, 2), draw_vector(draw, 2)
            body["position"] = [round(p - f, 3) for p, f in zip(point, follower_point)]
            if base != "ground":
                body["relative_to"] = base
            first = draw.choice([mode for mode in MODES if mode != "free"])
            joints[f"j{i}"] = {"between": [base, name], "point": point, "follower_point": follower_point,
                               "modes": {mode: MODES[mode] for mode in sorted({first, "weld", "free", draw.choice(list(MODES))})},
                               "mode": first}
        self.tree = list(joints)
        if len(self.names) > 2 and draw.random() < 0.4:  # closes a loop later
            between = draw.sample(self.names, 2)
            joints["loop"] = {"between": between, "modes": {"free": {"rows": []}, "plane": {"rows": ["x"]}}, "mode": "free"}

    def add_shapes(self):
        """Gives bodies shapes, and pairs of them contacts and clearances; a joint's two bodies do not touch each other."""
        draw, bodies, joints = self.draw, self.scenario["bodies"], self.scenario["joints"]
        shaped = [name for name in self.names if draw.random() < 0.6]
        for name in shaped:
            bodies[name]["shape"] = [draw_shape(draw, hollow=name == shaped[0]) for _ in range(draw.randint(1, 3))]
        joined = [set(joint["between"]) for joint in joints.values()]
        pairs = [[a, b] for i, a in enumerate(shaped) for b in shaped[i + 1:] if {a, b} not in joined]
        contacts = self.scenario["contacts"] = {}
        for i, pair in enumerate(draw.sample(pairs, min(len(pairs), draw.randint(0, 3)))):
            stiffness = min(bodies[body]["mass"] for body in pair) * draw.uniform(10, MOST_FREQUENCY) ** 2
            contacts[f"k{i}"] = {"between": pair, draw.choice(("stiffness", "hertz_stiffness")): round(stiffness, 3),
                                 "friction": draw.choice((0, 0.3)), "slip_speed": 0.1, "enabled": draw.random() < 0.9,
                                 **draw.choice(({}, {"damping": 0.2}, {"restitution": {"coefficient": 0.5, "speed": 1}}))}
        if contacts:
            self.scenario["step"]["contact_substeps"] = draw.choice((1, 2, 8, "auto"))
        if pairs and draw.random() < 0.5:
            self.watched = self.scenario["clearance"] = draw.sample(pairs, min(len(pairs), 2))

    def add_rigid(self):
        """Away from all others, a stool that is pressed on a table: it bounces, slides, tips and falls off. In every second scenario."""
        draw = random.Random(f"{self.scenario['name']} rigid")
        if draw.random() < 0.5:
            return
        bodies, mass = self.scenario["bodies"], round(draw.uniform(0.5, 5), 3)
        table = [{"box": {"size": [1.2, 1.2, 0.4]}}, {"cylinder": {"from": [0.3, 0, 0.1], "to": [0.3, 0, 0.3], "radius": 0.2}},
                 {"capsule": {"from": [-0.5, -0.3, 0.2], "to": [-0.2, 0.5, 0.2], "radius": 0.1}}]
        feet = [{"sphere": {"centre": [x, y, -0.2], "radius": 0.05}} for x, y in ((0.2, 0.15), (-0.2, 0.15), (0.2, -0.15), (-0.2, -0.15))]
        bodies["table"] = {"mass": 40, "inertia": [5, 5, 9], "position": [60, 0, 0], "rate": draw_vector(draw, 0.3), "shape": table[:draw.randint(1, 3)]}
        bodies["stool"] = {"mass": mass, "inertia": [round(mass * j, 4) for j in (0.02, 0.025, 0.03)], "position": [60, 0, 0.6],
                           "velocity": draw_vector(draw, 0.5)[:2] + [-1], "rate": draw_vector(draw, 1), "shape": feet}
        self.scenario["contacts"]["rigid"] = {"between": ["table", "stool"], "rigid": True, "restitution": draw.choice((0, 0.3, 0.8, 1)),
                                              **draw.choice(({}, {"settle": 0.002})), **draw.choice(({}, {"friction": 0.3}))}
        self.scenario["elements"]["press"] = {"type": "force", "body": "stool", "frame": "world", "direction": [0, 0, -1],
                                              "profile": draw_profile(draw, 10 * mass)}

    def add_elements(self):
        draw, elements = self.draw, self.scenario.setdefault("elements", {})
        bodies = self.scenario["bodies"]
        for i in range(draw.randint(0, 6)):
            kind, name = draw.randrange(6), draw.choice(self.names)
            mass = bodies[name]["mass"]
            if kind < 2:
                elements[f"e{i}"] = {"type": ("thrust", "torque")[kind], "body": name, "direction": draw_vector(draw, 1)[:2] + [1],
                                     "profile": draw_profile(draw, draw.uniform(0.2, 3) * mass), "enabled": draw.random() < 0.8}
                if self.scenario["channels"] and draw.random() < 0.6:
                    elements[f"e{i}"]["channel"] = draw.choice(list(self.scenario["channels"]))
            elif kind == 2 and len(self.names) > 1:
                between = draw.sample(self.names, 2)
                stiffness = min(bodies[body]["mass"] for body in between) * draw.uniform(1, 10) ** 2
                elements[f"e{i}"] = {"type": "spring", "between": between, "stiffness": round(stiffness, 3), "damping": round(stiffness / 50, 3),
                                     "free_length": 1, "push_only": draw.random() < 0.3}
            elif kind == 3 and self.tree:
                joint = draw.choice(self.tree)
                ends = [body for body in self.scenario["joints"][joint]["between"] if body != "ground"]
                inertia = min(min(bodies[body]["inertia"]) for body in ends)
                stiffness = inertia * draw.uniform(0.5, math.sqrt(MOST_FREQUENCY)) ** 2
                elements[f"e{i}"] = {"type": "joint_spring", "joint": joint, "axis": draw.choice(("rot_x", "rot_y", "rot_z")),
                                     "stiffness": round(stiffness, 4), "damping": round(stiffness / 20, 4), "rest": round(draw.uniform(-0.3, 0.3), 3)}
            elif kind == 4 and len(self.names) > 1:
                between = draw.sample(self.names, 2)
                force = min(bodies[body]["mass"] for body in between) * draw.uniform(1, 10)
                elements[f"e{i}"] = {"type": "pusher", "between": between, "stroke": round(draw.uniform(0.05, 1), 3), "preload": round(force, 3),
                                     "stiffness": round(force / 2, 3), "damping": round(force / 50, 3), "friction": round(force / 100, 4),
                                     "friction_speed": 0.1, "pull_only": draw.random() < 0.2,
                                     **draw.choice(({}, {"guide": draw_vector(draw, 1)[:2] + [1]}))}

    def add_sensors(self):
        draw, sensors = self.draw, self.scenario.setdefault("sensors", {})
        for i in range(draw.randint(0, 5)):
            kind = draw.choice(("position", "attitude", "velocity", "rate", "acceleration", "specific_force"))
            sensors[f"s{i}"] = {"type": kind, "body": draw.choice(self.names)}
        for joint in self.tree[:2]:
            sensors[f"force_{joint}"] = {"type": "reaction", "joint": joint}

    def add_events(self):
        draw, events = self.draw, self.scenario.setdefault("events", [])
        until = self.scenario["step"]["until"]
        for i in range(draw.randint(0, 8)):
            event = {"name": f"event{i}", "when": self.draw_condition(until), "then": [self.draw_action()]}
            if draw.random() < 0.3:
                event["delay"] = round(draw.uniform(0, 0.05), 4)
            if draw.random() < 0.2:
                event["repeat"] = True
            events.append(event)

    def draw_condition(self, until):
        draw, kind = self.draw, self.draw.randrange(7)
        if kind == 0 and self.tree:
            return {"speed": {"joint": draw.choice(self.tree), "axis": draw.choice(("x", "rot_z"))}, "above": round(draw.uniform(0, 1), 3)}
        if kind == 1:
            return {"body_rate": draw.choice(self.names), "above": round(draw.uniform(0, 2), 3)}
        if kind == 2 and self.tree:
            return {"reaction": {"joint": draw.choice(self.tree), "row": "x"}, "below": round(draw.uniform(-10, 10), 3)}
        if kind == 3:
            return {"all": [{"time": round(draw.uniform(0, until), 4)}, {"not": {"signal": "fuse"}}]}
        if kind == 4 and self.watched:
            return {"clearance": {"between": draw.choice(self.watched)}, "below": round(draw.uniform(-0.2, 1), 3)}
        if kind == 5 and self.scenario["contacts"]:
            return {"contact": draw.choice(list(self.scenario["contacts"]))}
        return {"time": round(draw.uniform(0, until), 4)}

    def draw_action(self):
        draw, kind = self.draw, self.draw.randrange(4)
        joints, elements = self.scenario["joints"], list(self.scenario["elements"])
        if kind < 2 and joints:
            joint = draw.choice(list(joints))
            # Not a cross: its axes would be pulled together at once from wherever they are, which no step resolves.
            modes = [mode for mode in joints[joint]["modes"] if mode != "cross"]
            return {"set_mode": {"joint": joint, "mode": draw.choice(modes)}}
        if kind == 2 and elements + list(self.scenario["contacts"]):
            elements += list(self.scenario["contacts"])
            return draw.choice(({"switch": {"element": draw.choice(elements), "to": draw.choice((True, False, 0.5))}},
                                {"ramp": {"element": draw.choice(elements), "to": 0, "over": 0.1}}))
        return {"raise": {"signal": "fuse", "to": draw.choice((0, 1, 2))}}


def build_scenario(seed):
    """Returns YAML text: JSON is YAML. Signals that no event raises must be declared."""
    scenario = ScenarioDraw(seed).build()
    scenario["signals"] = ["fuse"]
    return json.dumps(scenario, indent=1)


def build_faults(seed, sensors, channels, participants):
    """Returns a fault script for a scenario with these names."""
    draw, faults = random.Random(seed), []
    messages = ("State", "StepAck", "Command") if participants else ()
    for _ in range(draw.randint(1, 6)):
        first = draw.randrange(600)
        fault = {"ticks": draw.choice((first, [first, first + draw.randrange(200)], [first, "end"]))}
        kind = draw.choice(("drop", "delay", "duplicate", "reorder", "corrupt", "stick", "bias", "dead", "jam"))
        if kind in ("stick", "bias") and sensors:
            sensor = draw.choice(sensors)
            fault[kind] = sensor if kind == "stick" else {"sensor": sensor, "by": round(draw.uniform(-1, 1), 3)}
        elif kind in ("dead", "jam") and channels:
            fault[kind] = draw.choice(channels)
        elif kind in ("drop", "delay", "duplicate", "reorder", "corrupt") and messages:
            fault[kind] = {"message": draw.choice(messages)}
            if kind == "delay":
                fault[kind]["time"] = f"{draw.randint(1, 5)} ms"
            fault["probability"] = round(draw.uniform(0.01, 0.3), 3)
        else:
            continue
        faults.append(fault)
    return json.dumps({"unlatch_faults": 1, "seed": seed, "faults": faults}, indent=1)
