#!/usr/bin/env python3
"""The zone that flexible bodies leave free (tools/envelope), against closed forms of rigid motions and the clearances of the run. Run by ctest:

    envelope_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import json
import math

from processes import BIN, SCENARIOS, SOURCE, UNLATCH, ProcessTest, call, main

RADIUS, STEPS = 2.0, 1800  # m, of half a ring; parts of it
AWAY = RADIUS * math.pi / STEPS  # m, between two points of it
FAIRING = SCENARIOS / "fairing/scenario.yaml"


def write_ring(path):
    """Writes half a ring of equal mass points at z 0 and at z 1, y > 0, and a mode without excitation."""
    lines = ["unlatch modes 1", "frequencies 50"]
    points = []
    for z in (0, 1):
        for k in range(STEPS + 1):
            angle = math.pi * k / STEPS
            wave = math.cos(2 * angle)
            points.append(f"1e-3 {RADIUS * math.cos(angle)!r} {RADIUS * math.sin(angle)!r} {z} {wave * math.cos(angle)!r} {wave * math.sin(angle)!r} 0")
    lines += ["marker front 0 2 0", "0 -1 0 0 0 0", f"points {len(points)}", *points, "end"]
    path.write_text("\n".join(lines) + "\n")


SCENARIO = """
unlatch: 1
name: ring
step: {{dt: 10 ms, until: 0.5}}
bodies:
  core: {{mass: 1000, inertia: [1000, 1000, 1000], position: [0, 0, -3], {core}}}
  half: {{flexible: {{modes: ring.modes}}, origin: [0, 0, 0], velocity: {velocity}}}
  front: {{marker: {{of: half, at: front}}}}
"""


class EnvelopeTest(ProcessTest):
    def sweep(self, scenario, *options, every=1):
        out = self.folder / "zone.json"
        self.printed = self.run_ok(SOURCE / "tools/envelope", scenario, "--bin", BIN, "--seen-from", "core", "--origin", "0,0,3", "--every", every,
                                "--json", out, *options).stdout
        return json.loads(out.read_text())

    def fly_ring(self, velocity, core="velocity: [0, 0, 0]", azimuths=36):
        write_ring(self.folder / "ring.modes")
        path = self.folder / "ring.yaml"
        path.write_text(SCENARIO.format(velocity=velocity, core=core))
        return self.sweep(path, "--of", "half", "--stations=-0.5:1.5:1", "--azimuths", azimuths)

    # A circle moved by -s in y has the radius -s sin(a) + sqrt(R^2 - s^2 cos(a)^2) at the azimuth a: smallest at the end.
    def test_half_a_ring_that_moves_inwards_leaves_the_closed_form(self):
        zone = self.fly_ring("[0, -1, 0]")
        moved = 0.5
        for row in zone["radius"]:
            for j, radius in enumerate(row):
                ends = zone["azimuths"][j:j + 2]
                if ends[0] < 0.01 or ends[1] > math.pi - 0.01:
                    continue  # the ring's ends leave these
                wanted = min(-moved * math.sin(a) + math.sqrt(RADIUS**2 - (moved * math.cos(a))**2)
                             for a in (ends[0] + (ends[1] - ends[0]) * k / 100 for k in range(101)))
                self.assertGreater(radius, wanted - 1e-9)
                self.assertLess(radius, wanted + AWAY)
        self.assertEqual(zone["stiff"], zone["radius"])  # no deformation, bit for bit
        nose = zone["azimuths"].index(min(zone["azimuths"], key=lambda a: abs(a - math.pi / 2)))
        self.assertAlmostEqual(zone["time"][0][nose], 0.5, delta=1e-9)

    def test_what_moves_outwards_leaves_what_it_was(self):
        zone = self.fly_ring("[0, 1, 0]")
        for radius, start in zip(zone["radius"], zone["start"]):
            for a, b in zip(radius, start):
                if b is not None:
                    self.assertAlmostEqual(a, RADIUS, delta=1e-9)
                    self.assertEqual(a, b)
        self.assertTrue(all(value is None for value in zone["radius"][0][1:17]))  # no points on the side of -y

    # Relative to a body that turns about the axis, the half ring sweeps all azimuths that it passes, at its own radius.
    def test_the_axes_are_those_of_the_body(self):
        zone = self.fly_ring("[0, 0, 0]", core="rate: [0, 0, 6.283185307179586]")
        for row in zone["radius"]:
            self.assertTrue(all(value is not None and abs(value - RADIUS) < 1e-9 for value in row))

    # In the payload's zone a marker's clearance is its radius less that of the payload and of the marker's sphere. tools/envelope itself compares
    # the places of all markers with the run's.
    def test_the_fairings_room_ends_where_the_watched_points_came(self):
        for point, options, code in (("half1_middle_left", (), 0), ("half1_top_left", ("--set", "elements.push1_left.enabled=false"), 1)):
            run = self.run_json(UNLATCH, "run", FAIRING, "--until", "0.6", *options, code=code)
            radius = next(pair["min"] for pair in run["clearance"] if pair["pair"] == ["core", point]) + 1.6 + 0.005
            place = {"half1_middle_left": "3.5:4.5:1", "half1_top_left": "7:8.5:1.5"}[point]
            zone = self.sweep(FAIRING, "--of", "half1,half2", "--stations", place, "--until", "0.6", *options, every=2)
            found = min(value for value in zone["radius"][0] if value is not None)
            self.assertLess(found, radius + 1e-3, point)
            if not options:  # no point of the file bends inwards more than the free edge
                self.assertGreater(found, radius - 0.02)
                self.assertGreater(min(value for value in zone["stiff"][0] if value is not None), 1.99)  # elasticity takes the rest

    def test_equal_halves_leave_a_mirror_image(self):
        zone = self.sweep(FAIRING, "--of", "half1", "--stations", "0:8:1", "--azimuths", "36", "--until", "1", every=20)
        for row in zone["radius"]:
            for j in range(20, 27):  # the half's middle is at 90 degrees
                self.assertAlmostEqual(row[j], row[53 - j], delta=1e-3)

    def test_the_wall_takes_half_of_its_thickness(self):
        options = ("--of", "half1", "--stations", "0:8:2", "--until", "0.1")
        bare, thick = self.sweep(FAIRING, *options, every=20), self.sweep(FAIRING, *options, "--wall", "0.01", every=20)
        for a, b in zip(sum(bare["radius"], []), sum(thick["radius"], [])):
            self.assertTrue(a is b is None or abs(a - b - 0.005) < 1e-12)

    def test_a_campaigns_zone_is_the_least_of_its_samples(self):
        options = ("--of", "half1", "--stations", "0:14:2", "--until", "0.5")
        campaign = SCENARIOS / "fairing/campaign.yaml"
        both = self.sweep(campaign, *options, "--samples", "0:2", every=20)
        single = [self.sweep(campaign, *options, "--samples", f"{k}:{k + 1}", every=20) for k in (0, 1)]
        for k, row in enumerate(both["radius"]):
            for j, value in enumerate(row):
                found = [zone["radius"][k][j] for zone in single if zone["radius"][k][j] is not None]
                self.assertEqual(value, min(found) if found else None)
                if found:
                    self.assertEqual(single[both["sample"][k][j]]["radius"][k][j], value)

    def test_a_rigid_body_is_refused(self):
        result = call(SOURCE / "tools/envelope", FAIRING, "--bin", BIN, "--seen-from", "core", "--of", "core")
        self.assertEqual(result.returncode, 1)
        self.assertIn("core is no flexible body", result.stderr)


if __name__ == "__main__":
    main()
