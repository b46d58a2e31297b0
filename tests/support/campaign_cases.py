"""What the tests of `unlatch campaign` share: a scenario whose samples take no time, files of campaigns, how they are flown."""

import csv
import json
import math

from processes import UNLATCH, ProcessTest, call

# Scenario of a mass that falls for 5 steps: a sample takes no time. v: speed at the end, 0.05 s · 9.81 m/s2 + start.
BALL = """unlatch: 1
name: ball
step: {dt: 0.01, until: 0.05}
gravity: {uniform: [-9.81, 0, 0]}
bodies:
  ball: {mass: 2, inertia: [1, 1, 1], velocity: [0, 0, 0]}
  base: {mass: 1000, inertia: [9, 9, 9]}
requirements:
  - {id: fast, text: it is slow, velocity: {body: ball, relative_to: base}, at_most: 2.5}
"""


def read_table(folder):
    with open(folder / "samples.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


class CampaignCase(ProcessTest):
    CURVED = ("samples: 40\nparameters:\n  v: {path: 'bodies.ball.velocity[0]', uniform: {min: 0 m/s, max: 1 m/s}}\n"
              "outputs: [{of: ball.velocity}, {of: ball.vx, take: max}]\ncurves: [{of: [ball.vx, base.vx], every: 20 ms}]\n")

    # The speed of the ball is that of its start: two perpendicular normal numbers, so that P(speed > 2.5 m/s) is known: 1 - Φ for
    # one axis, exp(-r²/2) for a circle. Second oracle: OpenTURNS' SubsetSampling of the same function, an implementation with
    # another sampler (modified Metropolis) and other numbers, so estimates and the coefficients of variation that both tell are
    # compared, not bits.
    RARE = ("sampling: subset\nsamples: {samples}\nseed: {seed}\nsubset: {{of: {of}}}\nparameters:\n"
            "  x: {{path: 'bodies.ball.velocity[0]', normal: {{mean: {mean} m/s, sigma: {sigma} m/s}}}}\n"
            "  y: {{path: 'bodies.ball.velocity[1]', normal: {{mean: 0 m/s, sigma: {sigma_y} m/s}}}}\n")

    def write(self, rest, name="c.yaml"):
        (self.folder / "ball.yaml").write_text(BALL)
        path = self.folder / name
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: ball.yaml\n" + rest)
        return path

    def run_campaign(self, path, out, *options, code=0):
        done = call(UNLATCH, "campaign", path, "--out", self.folder / out, "--json", "-", *options)
        self.assertIn(done.returncode, (code,) if isinstance(code, int) else code, done.stderr)
        return json.loads(done.stdout)

    def write_rare(self, seed=1, samples=1000, of="fast", mean=0, sigma=2.5 / math.sqrt(-2 * math.log(1e-5)), sigma_y=None, name="rare.yaml"):
        return self.write(self.RARE.format(seed=seed, samples=samples, of=of, mean=mean, sigma=repr(sigma), sigma_y=repr(sigma if sigma_y is None else sigma_y)), name)
