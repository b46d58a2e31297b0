#!/usr/bin/env python3
"""Facts about `unlatch import`: imported models move as expected, and hostile files are refused. Run by ctest like tools_test.py."""

import math

from processes import UNLATCH, ProcessTest, call, main

MASS, LENGTH, ROUND = 2.0, 0.7, 0.05  # kg; m from the pivot to the centre of mass; kg m2 about the swinging axis
PIVOT = ROUND + MASS * LENGTH**2  # kg m2
# Quarter of a swing from the horizontal: K(sin 45 deg) sqrt(I / (m g l)), s.
QUARTER = 1.8540746773013719 * math.sqrt(PIVOT / (MASS * 9.81 * LENGTH))
DT = round(QUARTER / 2000 * 1e9) * 1e-9  # s, a whole number of ns
# Distance at the end of the quarter, whose rounding is half a nanosecond in each of 2000 steps, at more than the lowest point's
# speed.
NEAR = 2000 * 0.5e-9 * 10

INERTIA = f'<inertia ixx="0.03" iyy="{ROUND}" izz="0.06" ixy="0" ixz="0" iyz="0"/>'
# Pendulum that points along x at zero; the hinge's axis is y. Inertia in a frame that is turned by 0.3 about y, which does not
# change iyy.
PENDULUM = f"""<?xml version="1.0"?>
<robot name="pendulum">
  <link name="world"/>
  <link name="rod 1">
    <inertial><origin xyz="{LENGTH} 0 0" rpy="0 0.3 0"/><mass value="{MASS}"/>{INERTIA}</inertial>
    <collision><origin xyz="{LENGTH} 0 0" rpy="0 1.5707963267948966 0"/><geometry><cylinder radius="0.02" length="0.4"/></geometry></collision>
  </link>
  <joint name="hinge" type="continuous">
    <parent link="world"/><child link="rod 1"/><origin xyz="1 2 3" rpy="0 0 0"/><axis xyz="0 1 0"/>
  </joint>
</robot>"""


def link(name, mass=1.0, inertia='<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>', more=""):
    return f'<link name="{name}"><inertial><mass value="{mass}"/>{inertia}</inertial>{more}</link>'


def joint(parent, child, kind="fixed", more=""):
    return (f'<joint name="{parent}-{child}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="0 0 1" rpy="0 0 0"/>{more}</joint>')


def robot(*parts):
    return '<robot name="r">' + "".join(parts) + "</robot>"


class ImportTest(ProcessTest):
    def bring_in(self, text, name="in.urdf", *options, code=0):
        source, out = self.folder / name, self.folder / "out.yaml"
        source.write_text(text)
        result = self.run_ok(UNLATCH, "import", source, "--out", out, "--force", *options, code=code)
        if code == 0:
            self.run_ok(UNLATCH, "check", out)
        else:
            self.assertTrue(result.stderr.strip())
            self.assertLess(len(result.stderr), 2000)
        return out if code == 0 else result.stderr

    def swing(self, scenario):
        report = self.run_json(UNLATCH, "run", scenario, "--dt", repr(DT), "--until", repr(2000 * DT))
        return next(iter(report["samples"][0]["bodies"].values()))

    def check_quarter(self, body):
        speed = math.sqrt(2 * MASS * 9.81 * LENGTH / PIVOT)
        self.assertAlmostEqual(body["p"][0], 1, delta=NEAR)
        self.assertAlmostEqual(body["p"][1], 2, delta=1e-12)
        self.assertAlmostEqual(body["p"][2], 3 - LENGTH, delta=NEAR)
        self.assertAlmostEqual(math.hypot(*body["w"]), speed, delta=NEAR)

    def test_a_pendulum_swings_as_the_elliptic_integral_says(self):
        self.check_quarter(self.swing(self.bring_in(PENDULUM)))

    def test_it_is_the_pendulum_that_a_hand_would_write(self):
        imported = self.swing(self.bring_in(PENDULUM))
        by_hand = self.folder / "hand.yaml"
        by_hand.write_text(f"""unlatch: 1
name: pendulum
step: {{dt: 0.001, until: 1}}
gravity: {{uniform: [0, 0, -9.81]}}
bodies:
  rod: {{mass: {MASS}, inertia: [0.04, {ROUND}, 0.05], position: [{1 + LENGTH}, 2, 3]}}
joints:
  hinge:
    between: [ground, rod]
    point: [1, 2, 3]
    follower_point: [{-LENGTH}, 0, 0]
    axes: {{z: [0, 1, 0], x: [1, 0, 0]}}
    modes: {{hinge: {{kind: revolute, axis: z}}}}
""")
        mine = self.swing(by_hand)
        for key in ("p", "q", "v"):  # the rounding of two ways to write the same hinge
            for a, b in zip(imported[key], mine[key]):
                self.assertAlmostEqual(a, b, delta=1e-11)

    def test_the_same_pendulum_as_mjcf(self):
        text = f"""<mujoco model="pendulum"><option gravity="0 0 -9.81" timestep="0.002"/><worldbody>
<geom type="plane" size="1 1 1"/>
<body name="rod" pos="1 2 3"><joint name="hinge" type="hinge" axis="0 1 0"/>
<inertial pos="{LENGTH} 0 0" mass="{MASS}" diaginertia="0.03 {ROUND} 0.06"/>
<geom type="capsule" fromto="0 0 0 {LENGTH} 0 0" size="0.02"/></body></worldbody></mujoco>"""
        source, out = self.folder / "in.xml", self.folder / "out.yaml"
        source.write_text(text)
        result = call(UNLATCH, "import", source, "--out", out)
        if result.returncode == 3:
            self.skipTest("this program was built without MuJoCo")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.run_ok(UNLATCH, "check", out)
        self.assertIn("dt: 0.002", out.read_text())
        self.check_quarter(self.swing(out))

    def import_mjcf(self, text, code=0):
        source, out = self.folder / "in.xml", self.folder / "out.yaml"
        source.write_text(text)
        result = call(UNLATCH, "import", source, "--out", out, "--force")
        if result.returncode == 3:
            self.skipTest("this program was built without MuJoCo")
        self.assertEqual(result.returncode, code, result.stderr)
        return out.read_text() if code == 0 else result.stderr

    def test_what_mjcf_switches_off_is_off(self):
        hinge = ('<worldbody><body name="a" pos="0 0 1"><joint name="h" axis="0 1 0" stiffness="50" damping="3"/>'
                 '<geom type="capsule" fromto="0 0 0 0.6 0 0" size="0.03"/></body>'
                 '<body name="b" pos="0.6 0 1"><freejoint/><geom size="0.1" pos="0.2 0 0"/></body></worldbody>'
                 '<equality><weld name="w" body1="a" body2="b"/></equality>')
        on = self.import_mjcf(f"<mujoco>{hinge}</mujoco>")
        self.assertIn("stiffness: 50", on)
        self.assertIn("  w:", on)
        passive = self.import_mjcf(f'<mujoco><option><flag passive="disable"/></option>{hinge}</mujoco>')
        self.assertNotIn("stiffness", passive)
        self.assertIn("the flag 'passive' disables them", passive)
        for flag in ("equality", "constraint"):
            off = self.import_mjcf(f'<mujoco><option><flag {flag}="disable"/></option>{hinge}</mujoco>')
            self.assertNotIn("  w:", off)
            self.assertIn("equality 'w' is left out: it is switched off", off)

    def test_whatever_of_mjcf_is_not_read_is_said(self):
        air = self.import_mjcf('<mujoco><option density="1.2" viscosity="2e-5" wind="5 0 0" integrator="RK4"/><worldbody>'
                               '<body><joint type="free" damping="2"/><geom size="0.1" fluidshape="ellipsoid"/></body></worldbody></mujoco>')
        for text in ("the option 'density'", "the option 'viscosity'", "the option 'wind'", "the option 'integrator'", "geom_fluid of 1 geoms",
                     "damper of a free joint"):
            self.assertIn(text, air)
        plain = self.import_mjcf('<mujoco><worldbody><body><freejoint/><geom size="0.1"/></body></worldbody></mujoco>')
        self.assertNotIn("left out: ", plain)

    def test_a_weld_of_mjcf_in_another_pose_is_refused(self):
        bodies = ('<worldbody><body name="a"><freejoint/><geom size="0.1"/></body>'
                  '<body name="b" pos="1 0 0"><freejoint/><geom size="0.1"/></body></worldbody>')
        weld = '<equality><weld name="w" body1="a" body2="b" relpose="{} 0 0 1 0 0 0"/></equality>'
        self.assertIn("  w:", self.import_mjcf(f"<mujoco>{bodies}{weld.format(1)}</mujoco>"))
        self.assertIn("another relative pose (relpose)", self.import_mjcf(f"<mujoco>{bodies}{weld.format(0.5)}</mujoco>", code=2))

    def test_springs_dampers_universal_joints_and_loops_of_mjcf(self):
        text = """<mujoco model="loop"><worldbody>
<body name="a" pos="0 0 1"><joint name="ja" type="hinge" axis="0 1 0" stiffness="5" damping="0.25" springref="30"/>
<inertial pos="0.5 0 0" mass="1" diaginertia="0.1 0.1 0.1"/>
 <body name="b" pos="1 0 0"><joint name="b1" axis="1 0 0"/><joint name="b2" axis="0 1 0"/>
 <inertial pos="0.5 0 0" mass="1" diaginertia="0.1 0.1 0.1"/></body></body>
<body name="c" pos="0 3 0"><freejoint/><inertial pos="0 0 0" mass="2" diaginertia="1 1 1"/></body>
</worldbody><equality><connect name="eye" body1="b" body2="c" anchor="1 0 0"/></equality>
<actuator><motor joint="ja"/></actuator></mujoco>"""
        source, out = self.folder / "in.xml", self.folder / "out.yaml"
        source.write_text(text)
        result = call(UNLATCH, "import", source, "--out", out)
        if result.returncode == 3:
            self.skipTest("this program was built without MuJoCo")
        self.assertEqual(result.returncode, 0, result.stderr)
        plan = self.run_json(UNLATCH, "check", out)
        self.assertEqual([joint["name"] for joint in plan["joints"]], ["ja", "b1", "eye"])
        self.assertEqual([joint["mode"] for joint in plan["joints"]], ["hinge", "universal", "ball"])
        written = out.read_text()
        self.assertIn("stiffness: 5, damping: 0.25, rest: 0.52359877", written)
        self.assertIn("left out: 1 actuators", written)

    def test_a_link_called_on_gets_a_name_that_yaml_1_1_leaves_alone(self):
        out = self.bring_in(robot(link("base"), link("On"), joint("base", "On")))
        self.assertEqual([body["name"] for body in self.run_json(UNLATCH, "check", out)["bodies"]], ["base", "body_On"])

    def test_what_was_rounded_when_typed_is_mended_and_units_are_written(self):
        shape = '<collision><origin xyz="0 0 0" rpy="0 1.5708 0"/><geometry><cylinder radius="0.1" length="1"/></geometry></collision>'
        text = robot(link("base"), link("arm", more=shape), joint("base", "arm", "revolute", '<axis xyz="0 0 1"/>'
                     '<limit effort="1" velocity="1"/><dynamics damping="0.5"/>')).replace('rpy="0 0 0"/><axis', 'rpy="1.5708 0 0"/><axis')
        out = self.bring_in(text).read_text()
        head, _, scenario = out.partition("unlatch: 1")
        self.assertNotRegex(scenario, r"\de-\d", "a number that rounding has left")
        self.assertIn("cylinder: {from: [-0.5, 0, 0], to: [0.5, 0, 0], radius: 0.1}", out)
        self.assertIn("mass: 1 kg", out)
        for unit in ("# kg m2, about the centre of mass", "# m, of the centre of mass", "# w x y z", "# m/s2", "N m s/rad"):
            self.assertIn(unit, out)
        self.assertIn("link 'base' has no geometry: no clearance to it is computed", head)
        self.assertNotIn("link 'arm' has no geometry", head)
        self.assertIn("such as 1.5708, are taken as right angles", head)

    def test_frames_without_mass_belong_to_who_carries_them(self):
        tool = '<link name="tool"><visual><geometry><box size="1 2 3"/></geometry></visual></link>'
        out = self.bring_in(robot(link("base"), tool, link("arm"), joint("base", "tool"), joint("tool", "arm", "revolute", '<axis xyz="1 0 0"/><limit lower="-1" upper="1" effort="1" velocity="1"/><dynamics damping="0.5"/>')))
        plan = self.run_json(UNLATCH, "check", out)
        self.assertEqual([body["name"] for body in plan["bodies"]], ["base", "arm"])
        self.assertEqual(plan["joints"][0]["between"], ["base", "arm"])
        text = out.read_text()
        self.assertIn("centre: [0, 0, 1]", text)  # the tool's box, in the base's axes
        self.assertIn("point: [0, 0, 2]", text)
        self.assertIn("damping: 0.5", text)
        self.assertIn("range is left out", text)
        self.assertIn("flies free", text)
        self.assertIn("weld", self.bring_in((self.folder / "in.urdf").read_text(), "in.urdf", "--fixed-base").read_text())

    def test_what_urdfdom_ignores_is_said_or_refused(self):
        text = robot("\n", link("a"), "\n", link("b"), joint("a", "b"))
        self.assertIn("line 3: the attribute 'quat_xyzw' of <origin>",
                      self.bring_in(text.replace('rpy="0 0 0"', 'quat_xyzw="0 0 0 1"')).read_text())
        self.assertNotIn("is unknown", self.bring_in(text).read_text())
        self.assertIn("line 2: <xacro:include> is not expanded", self.bring_in(text.replace("\n", '\n<xacro:include filename="y"/>', 1), code=2))
        self.assertIn("not expanded", self.bring_in(text.replace('xyz="0 0 1"', 'xyz="0 0 ${length}"'), code=2))
        flat = '<collision><geometry><box size="0 0 0"/></geometry></collision>'
        self.assertIn("line 1: link 'a' has a shape without volume", self.bring_in(robot(link("a", more=flat), link("b"), joint("a", "b"))).read_text())
        several = robot(link("a"), link("b"), link("c"), joint("a", "b"), joint("a", "c"), joint("c", "b"))
        self.assertIn("line 1: link 'b' is the child of 2 joints, 'a-b', 'c-b'", self.bring_in(several, code=2))

    def test_a_cross_without_mass_between_two_hinges_is_a_universal_joint(self):
        limit = '<limit effort="1" velocity="1" lower="-1" upper="1"/>'
        first = joint("a", "cross", "revolute", '<axis xyz="1 0 0"/>' + limit)
        second = joint("cross", "b", "revolute", '<axis xyz="0 {} {}"/>' + limit).replace('xyz="0 0 1" rpy', 'xyz="0 0 0" rpy')
        parts = [link("a"), '<link name="cross"/>', link("b"), first]
        out = self.bring_in(robot(*parts, second.format(1, 0)))
        plan = self.run_json(UNLATCH, "check", out)
        self.assertEqual([(joint["mode"], joint["between"]) for joint in plan["joints"]], [("universal", ["a", "b"])])
        self.assertIn("point: [0, 0, 1]", out.read_text())
        skew = second.replace('xyz="0 {} {}"', 'xyz="1 1 0"')
        self.assertIn("needs no mass", self.bring_in(robot(*parts, skew), code=2))
        self.assertIn("needs no mass", self.bring_in(robot(*parts, second.format(1, 0).replace('"0 0 0" rpy', '"0 0 1" rpy')), code=2))

    def test_two_crosses_without_mass_between_three_hinges_are_a_ball_joint(self):
        limit = '<limit effort="1" velocity="1" lower="-1" upper="1"/>'

        def hinge(parent, child, axis, place="0 0 0"):
            return joint(parent, child, "revolute", f'<axis xyz="{axis}"/>' + limit).replace('xyz="0 0 1" rpy', f'xyz="{place}" rpy')

        crosses = ['<link name="c"/>', '<link name="d"/>']
        gimbal = [hinge("a", "c", "1 0 0", "0 0 1"), hinge("c", "d", "0 1 0"), hinge("d", "b", "0 0 1")]
        out = self.bring_in(robot(link("a"), *crosses, link("b"), *gimbal))
        plan = self.run_json(UNLATCH, "check", out)
        self.assertEqual([(one["mode"], one["between"]) for one in plan["joints"]], [("ball", ["a", "b"])])
        four = [*gimbal[:2], hinge("d", "e", "0 0 1"), hinge("e", "b", "1 0 0")]
        self.assertIn("needs no mass", self.bring_in(robot(link("a"), *crosses, '<link name="e"/>', link("b"), *four), code=2))

    def test_what_is_hostile_or_impossible_is_refused_in_a_sentence(self):
        deep = "<a>" * 100000
        cases = {
            "rubbish": "rubbish",
            "empty": "",
            "deep": "<robot name='r'>" + deep,
            "entities": "<!DOCTYPE r [<!ENTITY a 'aaaa'>]><robot name='r'><link name='&a;'/></robot>",
            "nan mass": robot(link("a"), link("b", "nan"), joint("a", "b")),
            "infinite mass": robot(link("a"), link("b", "1e999"), joint("a", "b")),
            "nan inertia": robot(link("a", 1, '<inertia ixx="nan" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>')),
            "negative inertia": robot(link("a", 1, '<inertia ixx="-1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>')),
            "cycle": robot(link("root"), link("a"), link("b"), joint("a", "b"), joint("b", "a")),
            "own parent": robot(link("a"), joint("a", "a")),
            "two roots": robot(link("a"), link("b")),
            "nowhere": robot(link("a"), joint("a", "missing")),
            "massless": robot(link("a"), '<link name="b"/>', joint("a", "b", "continuous", '<axis xyz="0 0 1"/>')),
            "no axis": robot(link("a"), link("b"), joint("a", "b", "continuous", '<axis xyz="0 0 0"/>')),
            "no body": robot('<link name="a"/>'),
        }
        for name, text in cases.items():
            with self.subTest(name):
                self.bring_in(text, code=2)
        for name, text in {"bad": "<mujoco><worldbody><body><joint/></body></worldbody></mujoco>",
                           "nan": "<mujoco><worldbody><body><joint/><inertial pos='0 0 0' mass='nan' diaginertia='1 1 1'/></body></worldbody></mujoco>",
                           "three hinges": "<mujoco><worldbody><body><joint axis='1 0 0'/><joint axis='0 1 0'/><joint axis='0 0 1'/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></worldbody></mujoco>",
                           "greedy": "<mujoco><size njmax='2000000000' nconmax='2000000000' nstack='2000000000'/><worldbody><body><joint/><inertial pos='0 0 0' mass='1' diaginertia='1 1 1'/></body></worldbody></mujoco>",
                           "no file": "<mujoco><include file='/etc/passwd'/></mujoco>"}.items():
            with self.subTest(name):
                (self.folder / "in.xml").write_text(text)
                result = call(UNLATCH, "import", self.folder / "in.xml", "--out", self.folder / "x.yaml", "--force")
                if result.returncode == 3:
                    continue
                self.assertEqual(result.returncode, 0 if name == "greedy" and not result.returncode else 2, result.stderr)
        (self.folder / "huge.urdf").write_bytes(b" " * (17 << 20))
        self.assertIn("16 MiB", self.run_ok(UNLATCH, "import", self.folder / "huge.urdf", "--out", "-", code=2).stderr)
        self.run_ok(UNLATCH, "import", self.folder, "--out", "-", code=2)
        self.run_ok(UNLATCH, "import", self.folder / "none.urdf", "--out", "-", code=2)

    def test_a_mistake_has_its_line_in_the_urdf(self):
        bad = "\n".join(("<robot name='r'>", link("a"), link("b", "-2"), link("c", 1, '<inertia ixx="1" iyy="1" izz="5" ixy="0" ixz="0" iyz="0"/>'),
                         joint("a", "b"), joint("a", "c"), "</robot>"))
        said = self.bring_in(bad, code=2)
        self.assertIn("line 3: body 'b': its mass is -2 kg", said)
        self.assertIn("line 4: body 'c': its inertia", said)
        self.assertNotIn("the scenario that it makes", said)
        self.assertIn("line 3: it is no URDF", self.bring_in("\n".join(("<robot name='r'>", link("a"), joint("a", "missing"), "</robot>")), code=2))
        no_axis = joint("a", "b", "continuous", '<axis xyz="0 0 0"/>')
        self.assertIn("line 4: joint", self.bring_in("\n".join(("<robot name='r'>", link("a"), link("b"), no_axis, "</robot>")), code=2))

    def test_names_become_names_of_scenarios_and_nothing_is_overwritten(self):
        out = self.bring_in(robot(link("1 arm: {"), link("1_arm__ "), joint("1 arm: {", "1_arm__ ", "floating")))
        names = [body["name"] for body in self.run_json(UNLATCH, "check", out)["bodies"]]
        self.assertEqual(len(set(names)), 2)
        result = self.run_ok(UNLATCH, "import", self.folder / "in.urdf", "--out", out, code=2)
        self.assertIn("--force", result.stderr)


if __name__ == "__main__":
    main()
