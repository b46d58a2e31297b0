#!/usr/bin/env python3
"""Facts about the pages of `unlatch optimize`, in a browser.

    optimize_pages_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

from optimize_cases import FRONT, PROBLEM, SCENARIO, OptimizeCase
from processes import main


class OptimizePagesTest(OptimizeCase):
    def test_the_page_shows_the_result_the_search_slices_and_the_flight_before_and_after(self):
        hostile = "</script><script>window.struck = 1</script>"
        far = "  - {id: far, position: {body: block, along: [1, 1, 0]}, take: final, at_least: 1 m}\n"
        slow = "  - {id: slow, velocity: {body: block, along: [1, 1, 0]}, take: peak, at_most: 5000 m/s}\n"
        (self.folder / "s.yaml").write_text(SCENARIO.replace(far, far + slow))
        self.optimize(PROBLEM + f"title: \"{hostile}\"\n", "o")
        ask = self.look_at("o")
        self.assertEqual(ask("document.getElementById('title').textContent"), hostile)
        self.assertEqual(ask("window.struck === undefined"), True)
        self.assertEqual(ask("document.querySelector('#constraints tr:nth-child(2) td:nth-child(6)').textContent"), "active")
        layers = self.browser.find_layers
        (met,) = layers("search", "met")
        self.assertGreater(len(met["x"] + layers("search", "others")[0]["x"]), 10)
        self.assertEqual(len(layers("search", "best")), 1)
        self.browser.click_point("search", met["x"][0], met["y"][0])
        self.assertIn("Run ", ask("document.getElementById('picked').textContent"))
        # The position has a value only at the end; the speed has one at every tick.
        self.assertEqual(ask("[...document.querySelectorAll('#flights figcaption')].map((c) => c.textContent).includes('slow')"), True)
        self.assertEqual([len(layers("flight-1", name)) for name in ("before", "after")], [1, 1])
        self.assertEqual([limit["at"] for limit in layers("flight-1", "limit")], [5000])
        self.assertGreater(self.browser.count_pixels("flight-1"), 200)  # curves are drawn
        self.assertEqual(ask("document.querySelectorAll('#slices figure').length"), 4)  # objective and margins of both variables
        self.assertIn("same bits", ask("document.getElementById('verification').textContent"))

    def test_the_page_of_several_objectives_shows_the_front(self):
        front = self.optimize(FRONT, "o")["front"]
        ask = self.look_at("o")
        self.assertEqual(ask("document.getElementById('search-title').textContent"), "Pareto front")
        self.assertEqual([len(self.browser.find_layers("search", name)[0]["x"]) for name in ("front", "chosen")], [len(front), 1])

    def test_the_page_of_three_objectives_shows_the_front_in_each_pair(self):
        text = FRONT.replace("{minimise: b}]", "{minimise: b}, {maximise: a*b}]").replace("runs: 2000", "runs: 200")
        front = self.optimize(text, "o", code=None)["front"]
        ask = self.look_at("o")
        self.assertEqual(ask("[...document.querySelectorAll('#fronts figcaption')].map((c) => c.textContent)"), ["b over a", "a*b over a", "a*b over b"])
        layers = self.browser.find_layers
        for place in ("front-0-1", "front-0-2", "front-1-2"):
            self.assertEqual([len(layers(place, name)[0]["x"]) for name in ("front", "chosen")], [len(front), 1])
        (met,) = layers("front-1-2", "met")
        self.browser.click_point("front-1-2", met["x"][0], met["y"][0])
        self.assertIn("Run ", ask("document.getElementById('picked').textContent"))

    def test_the_page_of_a_problem_without_constraints_shows_the_flight_before_and_after(self):
        free = PROBLEM.replace("a^2 + 4*b^2", "(a - 1 N)^2 + b^2") + "constraints: []\n"
        self.optimize(free, "o")
        ask = self.look_at("o")  # the scenario's requirement
        captions = "[...document.querySelectorAll('#flights figcaption')].map((c) => c.textContent)"
        self.assertEqual(ask(captions), ["far"])
        self.assertEqual(self.browser.find_layers("flight-0", "limit"), [])
        (self.folder / "s.yaml").write_text(SCENARIO.partition("requirements:")[0])
        self.optimize(free, "p")
        ask = self.look_at("p")  # the body's velocity
        self.assertEqual(ask(captions), ["block.vx", "block.vy", "block.vz"])
        shown = [self.browser.find_layers(f"flight-{k}", name) for k in range(3) for name in ("before", "after")]
        self.assertEqual([len(layers) for layers in shown], 6 * [1])

    def test_the_page_says_that_no_point_meets_all_constraints(self):
        self.optimize(PROBLEM.replace("between: [0 N, 5 N]", "between: [0 N, 1 N]"), "o", code=1)
        ask = self.look_at("o")
        self.assertIn("No point meets all constraints", ask("document.getElementById('verdict').textContent"))


if __name__ == "__main__":
    main()
