#!/usr/bin/env python3
"""The documentation site of tools/docs: every link leads to a page and a place in it, nothing comes from a network, the search works in a
browser, code is shown as it is in the pages.

    site_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""
import importlib.util
import re
import subprocess
import tempfile
import unittest
import urllib.parse
from html.parser import HTMLParser
from pathlib import Path

from browser import Browser
from processes import HANG, SOURCE, main

TRACKS = ["1. Run", "2. A scenario of your own", "3. Flight software of your own", "4. A campaign", "5. An element of your own"]
# An empty question comes first: the search passes over one that equals the last.
SEARCH = ("(() => { document.getElementById('__search').checked = true; const box = document.querySelector('[data-md-component=search-query]');"
          " box.focus(); for (const text of ['', '%s']) { box.value = text; box.dispatchEvent(new Event('input', { bubbles: true }));"
          " box.dispatchEvent(new KeyboardEvent('keyup', { bubbles: true })); } })()")
FOUND = "[...document.querySelectorAll('.md-search-result__link')].map((link) => link.href)"


class Page(HTMLParser):
    """What a page links to, what it loads, its anchors, the texts of its code blocks."""

    def __init__(self, path):
        super().__init__()
        self.links, self.loaded, self.anchors, self.blocks = [], [], set(), []
        self.block = None
        self.feed(path.read_text(encoding="utf-8"))

    def handle_starttag(self, tag, attrs):
        values = dict(attrs)
        self.anchors.update(filter(None, (values.get("id"), values.get("name"))))
        if tag == "a" and values.get("href"):
            self.links.append(values["href"])
        if tag in ("script", "img", "iframe") and values.get("src"):
            self.loaded.append(values["src"])
        if tag == "link" and values.get("rel") != "canonical" and values.get("href"):
            self.loaded.append(values["href"])
        if tag == "pre":
            self.block = ""

    def handle_data(self, data):
        if self.block is not None:
            self.block += data

    def handle_endtag(self, tag):
        if tag == "pre":
            self.blocks.append(self.block.strip("\n"))
            self.block = None


class SiteTest(unittest.TestCase):
    def test_the_site_is_whole_needs_no_network_and_is_searched_in_a_browser(self):
        folder = tempfile.TemporaryDirectory(prefix="unlatch_site_")
        self.addCleanup(folder.cleanup)
        site = Path(folder.name).resolve()
        done = subprocess.run([SOURCE / "tools/docs", site], capture_output=True, text=True, timeout=HANG, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        described, names = map(int, re.search(r"^(\d+) of (\d+) public names have a description$", done.stdout, re.M).groups())
        self.assertEqual(described, names)
        self.assertGreater(names, 1000)
        pages = {path: Page(path) for path in site.rglob("*.html") if site / "cpp" not in path.parents}
        self.assertGreater(len(pages), 60)
        with self.subTest("links"):
            self.check_links(site, pages)
        with self.subTest("code"):
            self.check_code(site, pages)
        with self.subTest("browser"):
            self.check_browser(site)

    def test_c_functions_python_names_and_links_without_an_end_are_named(self):
        folder = tempfile.TemporaryDirectory(prefix="unlatch_site_")
        self.addCleanup(folder.cleanup)
        root = Path(folder.name)
        spec = importlib.util.spec_from_file_location("build_site", SOURCE / "tools/site/build.py")
        build = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(build)
        build.ROOT = root
        (root / "library/include").mkdir(parents=True)
        (root / "library/include/unlatch.h").write_text("/* Counts. */\nUNLATCH_API int unlatch_count(void);\n\nUNLATCH_API int unlatch_drop(void);\n")
        faults = []
        self.assertIn("unlatch_drop(void)", build.describe_header(faults))
        self.assertEqual(faults, ["library/include/unlatch.h: unlatch_drop has no description"])
        package = root / "library/python/unlatch"
        package.mkdir(parents=True)
        (package / "__init__.py").write_text('"""A package."""\n__all__ = ["good", "bad"]\n')
        (package / "names.py").write_text('def good(x: int) -> int:\n    """Good."""\ndef bad(): pass\ndef _own(): pass\n')
        python = build.PythonReference()
        self.assertIn("good(x: int) -> int", python.write())
        self.assertEqual(python.faults, ["library/python/unlatch/names.py:3: bad has no description"])
        subprocess.run(["git", "init", "-q", root], check=True)
        (root / "README.md").write_text("[there](library/python/unlatch/names.py) [nowhere](missing.md)\n")
        stage = build.Stage(root / "pages")
        stage.stage()
        self.assertEqual(stage.faults, ["README.md: a link to missing.md, which is not there"])
        self.assertIn("library/python/unlatch/names.py.md", (root / "pages/README.md").read_text())

    def check_links(self, site, pages):
        for path, page in pages.items():
            where = path.relative_to(site)
            if where.name == "404.html":  # of servers
                continue
            for target in page.loaded:
                self.assertNotRegex(target, r"^([a-z]+:)?//", f"{where} loads {target}")
            for target in page.links + page.loaded:
                if re.match(r"[a-z]+:", target):
                    continue
                name, _, anchor = urllib.parse.unquote(target.partition("?")[0]).partition("#")
                there = (path.parent / name).resolve() if name else path
                there = there / "index.html" if there.is_dir() else there
                self.assertTrue(there.is_file(), f"{where} links to {target}")
                if anchor and there in pages:
                    self.assertIn(anchor, pages[there].anchors, f"{where} links to {target}")

    def check_code(self, site, pages):
        blocks = 0
        for source, shown in (("START.md", "index.html"), ("README.md", "overview.html"), ("bridge/TUTORIAL.md", "bridge/TUTORIAL.html"),
                              ("hil/scenarios/CAMPAIGNS.md", "hil/scenarios/CAMPAIGNS.html")):
            for body in re.findall(r"^```[^\n]*\n(.*?)^```$", (SOURCE / source).read_text(), re.M | re.S):
                self.assertIn(body.strip("\n"), pages[site / shown].blocks, source)
                blocks += 1
        self.assertGreater(blocks, 15)
        header = (SOURCE / "library/include/unlatch.h").read_text()
        for name in set(re.findall(r"UNLATCH_API [^;(]*?(unlatch_\w+)\(", header)):
            self.assertTrue(any(name in block for block in pages[site / "reference/c.html"].blocks), name)

    def check_browser(self, site):
        browser = Browser()
        try:
            browser.call("Page.navigate", url=(site / "index.html").as_uri())
            browser.wait_for("document.readyState === 'complete' && document.querySelector('.md-search__form') !== null")
            self.assertEqual(browser.evaluate("[...document.querySelectorAll('article h2')].map((title) => title.firstChild.textContent)"), TRACKS)
            # A question that comes before the search has read its index may go unanswered: it is asked again after a while, and after
            # twice as long each time, since one that is being answered begins anew.
            ask = f"window.asked = Date.now(), {SEARCH % 'friction_speed'}"
            browser.evaluate(f"window.patience = 5000, {ask}")
            browser.wait_for(f"{FOUND}.length > 0 || (Date.now() > window.asked + window.patience && (window.patience *= 2, {ask}, false))")
            found = browser.evaluate(FOUND)
            self.assertTrue(any("hil/scenarios/REFERENCE.html" in link for link in found), found)
            self.assertEqual(browser.complaints, [])
            self.assertEqual([url for url in browser.requests if not url.startswith(("file:", "data:", "blob:"))], [])
        finally:
            browser.close()


if __name__ == "__main__":
    main()
