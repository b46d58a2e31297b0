#!/usr/bin/env python3
"""Facts about the pages of campaigns, in a browser.

    campaign_pages_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import os
import subprocess

from browser import Browser
from campaign_cases import CampaignCase, read_table
from processes import BIN, HANG, UNLATCH, call, main


class CampaignPagesTest(CampaignCase):
    def test_the_page_shows_curves_as_bands(self):
        self.run_campaign(self.write(self.CURVED), "out")
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page)
        browser = Browser()
        try:
            browser.open(page)
            ask = browser.evaluate
            self.assertEqual(ask("document.getElementById('curves').hidden"), False)
            self.assertEqual(ask("document.querySelectorAll('#curve option').length"), 2)
            widest, dark = browser.find_layers("bands", "all") + browser.find_layers("bands", "most")
            (median,) = browser.find_layers("bands", "median")
            self.assertEqual(median["x"], [0, 0.02, 0.04])
            for k, value in enumerate(median["y"]):
                order = [widest["low"][k], dark["low"][k], value, dark["high"][k], widest["high"][k]]
                self.assertEqual(order, sorted(order))
            self.assertEqual(ask("[...document.querySelectorAll('#quantity option')].filter((o) => o.textContent.startsWith('curve.')).length"), 0)
            self.assertEqual(ask("[...document.querySelectorAll('#quantity option')].filter((o) => o.textContent.startsWith('output.')).length"), 4)
            self.assertEqual(ask("[...document.querySelectorAll('#quantity option')].at(-1).textContent"), "v [m/s]")
            self.assertEqual(browser.complaints, [])
        finally:
            browser.close()

    def test_the_page_shows_the_campaign_in_a_browser_without_a_network(self):
        hostile = "</script><script>window.struck = 1</script>"
        path = self.write(f"title: \"{hostile}\"\nsamples: 200\nparameters:\n"
                          "  v: {path: 'bodies.ball.velocity[0]', uniform: {min: 0 m/s, max: 2.6 m/s}}\n")
        summary = self.run_campaign(path, "out", code=1)
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page, "--flights", "0")
        browser = Browser()
        try:
            browser.open(page)
            ask = browser.evaluate
            self.assertEqual(ask("document.getElementById('title').textContent"), hostile)
            self.assertEqual(ask("document.querySelectorAll('#worst .flight').length"), 0)
            heads = ask("[...document.querySelectorAll('#verdict th')].map((cell) => cell.textContent)")
            cells = ask("[...document.querySelectorAll('#verdict td')].map((cell) => cell.textContent)")
            verdict = dict(zip(heads, cells, strict=True))
            self.assertEqual(verdict["missing"], "0")
            self.assertEqual(verdict["tolerance, 99 % / 95 %"], "needs 299 values")  # of 200
            # The histogram is of all samples.
            self.assertEqual(ask("unlatchReport.quantities[0].distribution.counts.reduce((a, b) => a + b)"), 200)
            self.assertEqual(ask("window.struck === undefined"), True)
            self.assertEqual(ask("document.querySelector('#verdict .bad').textContent"), str(summary["requirements"][0]["failed"]))
            self.assertGreater(len(browser.find_layers("histogram", "samples")[0]["y"]), 5)
            self.assertEqual(len(browser.find_layers("histogram", "limit") + browser.find_layers("cdf", "limit")), 2)
            met, failed = (browser.find_layers("scatter", name)[0] for name in ("met", "failed"))
            self.assertEqual((len(met["x"]) + len(failed["x"]), len(failed["x"])), (200, summary["requirements"][0]["failed"]))
            self.assertGreater(browser.count_pixels("scatter"), 200)  # points are drawn
            self.assertIn(f"--sample {summary['worst'][0]} --log", ask("document.querySelector('#worst code').textContent"))
            self.assertEqual(ask("document.getElementById('rare').hidden"), True)
            browser.click_point("scatter", failed["x"][0], failed["y"][0])
            self.assertRegex(ask("document.getElementById('picked').textContent"), r"^Sample \d+: v ")
            # Another quantity: the input itself, which depends on nothing but itself.
            ask("(() => { const q = document.getElementById('quantity'); q.value = q.options.length - 1; q.dispatchEvent(new Event('change')); })()")
            self.assertEqual(browser.find_layers("histogram", "limit"), [])
            self.assertEqual(browser.complaints, [])
            self.assertEqual([url for url in browser.requests if not url.startswith(("file:", "data:"))], [])
        finally:
            browser.close()

    def test_the_worst_samples_fly_in_pages_of_their_own(self):
        path = self.write("samples: 30\nparameters:\n  v: {path: 'bodies.ball.velocity[0]', uniform: {min: 0 m/s, max: 2.6 m/s}}\n")
        quoted = "title=it's a ball; $HOME"  # in a shell
        summary = self.run_campaign(path, "out", "--set", "step.until=0.06", "--set", quoted, code=(0, 1))
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page, "--flights", "2")
        hashes = {int(row["sample"]): row["hash"] for row in read_table(self.folder / "out")}
        browser = Browser()
        try:
            browser.open(page)
            self.assertEqual(browser.evaluate("document.querySelectorAll('#worst .flight').length"), 2)
            for sample in summary["worst"][:2]:
                self.assertEqual(browser.evaluate(f"unlatchReport.data.flights[{sample}]"), f"page-{sample}.html")
                self.assertIn(hashes[sample], (self.folder / f"page-{sample}.html").read_text())  # the same flight
            # The command that is shown, in a shell: with the overrides.
            command = browser.evaluate("document.querySelector('#worst code').textContent")
            subprocess.run(["bash", "-c", command], cwd=self.folder, timeout=HANG, capture_output=True,
                           env={**os.environ, "PATH": f"{BIN}:{os.environ['PATH']}"})
            worst = summary["worst"][0]
            self.assertIn(hashes[worst], (self.folder / f"{worst}.html").read_text())
            self.assertEqual(browser.complaints, [])
        finally:
            browser.close()
        self.assertEqual(sorted(p.name for p in self.folder.glob("page*")), sorted(["page.html", *(f"page-{s}.html" for s in summary["worst"][:2])]))
        # Ten by default.
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", self.folder / "ten.html")
        self.assertEqual(len(list(self.folder.glob("ten-*.html"))), 10)
        path.write_text(path.read_text() + "seed: 9\n")
        done = call(UNLATCH, "campaign", "report", self.folder / "out", "--out", page, "--flights", "1")
        self.assertEqual(done.returncode, 3)
        self.assertIn("not the campaign file of these results any more", done.stderr)
        done = self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page)  # not asked for: a note
        self.assertIn("not the campaign file of these results any more", done.stderr)

    def test_a_page_without_samples_says_so(self):
        path = self.write("samples: 4\nparameters:\n  m: {path: bodies.ball.mass, uniform: {min: 1, max: 3}}\n")
        self.run_campaign(path, "out", code=(0, 1))
        results = self.folder / "out/results.bin"
        results.write_bytes(results.read_bytes()[:32])  # the header
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page)
        browser = Browser()
        try:
            browser.open(page)
            self.assertIn("no samples", browser.evaluate("document.getElementById('convergence').textContent"))
            self.assertEqual(browser.evaluate("window.unlatchReport !== undefined"), True)  # drawn to its end
            self.assertEqual(browser.complaints, [])
        finally:
            browser.close()

    def test_the_page_shows_rare_failures(self):
        summary = self.run_campaign(self.write_rare(samples=200), "out")
        page = self.folder / "page.html"
        self.run_ok(UNLATCH, "campaign", "report", self.folder / "out", "--out", page, "--flights", "0")
        browser = Browser()
        try:
            browser.open(page)
            ask = browser.evaluate
            self.assertEqual(ask("document.getElementById('rare').hidden"), False)
            text = ask("document.getElementById('rare-result').textContent")
            self.assertIn(f"{summary['rare']['failed_samples']} of them failed", text)
            levels = len(summary["rare"]["levels_run"])
            self.assertEqual(ask("document.querySelectorAll('#rare-levels tr').length"), levels + 1)
            self.assertEqual(len(browser.find_layers("rare-curve", "levels")[0]["x"]), levels)
            self.assertEqual(len(browser.find_layers("rare-curve", "curve")), 1)
            self.assertIn(f"--results {self.folder / 'out'} ", ask("document.querySelector('#worst code').textContent"))
            self.assertEqual(browser.complaints, [])
        finally:
            browser.close()


if __name__ == "__main__":
    main()
