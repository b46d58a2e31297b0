#!/usr/bin/env python3
"""The C library from outside: its symbols, its ABI against the last release, the installed tree.

    abi_test.py BIN_FOLDER SOURCE_FOLDER CXX CC [unittest options]
"""
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from processes import BOOSTERS, BIN, REFERENCE, SANITIZED, SOURCE, ProcessTest, call, main  # noqa: E402

CXX, CC = sys.argv[3:5]
del sys.argv[3:5]

BUILD = BIN.parent
HEADER = SOURCE / "library/include/unlatch.h"
BASELINE = SOURCE / "library/abi/x86_64.abi"
ENUMERATORS = SOURCE / "library/abi/enumerators.txt"
INCOMPATIBLE = 8  # bit of abidiff's exit code


def find_library():
    return next(BUILD.glob("lib*/**/libunlatch.so.0")).resolve()


def list_declared():
    return set(re.findall(r"UNLATCH_API [^;]*?(unlatch_\w+)\(", HEADER.read_text(encoding="utf-8")))


def list_enumerators():
    """Returns ["UNLATCH_OK = 0", …] of the header."""
    text = re.sub(r"/\*.*?\*/", "", HEADER.read_text(encoding="utf-8"), flags=re.S)
    return [f"{name} = {value}" for body in re.findall(r"enum\s*\{(.*?)\}", text, re.S)
            for name, value in re.findall(r"(UNLATCH_\w+)\s*=\s*(-?\d+)", body)]


class AbiTest(ProcessTest):
    def compare(self, baseline):
        if not shutil.which("abidiff"):
            self.skipTest("abidiff is not installed (tools/setup test)")
        if os.uname().machine != "x86_64" or SANITIZED:
            self.skipTest("the baseline is of the x86-64 release build")
        return call("abidiff", "--exported-interfaces-only", "--no-added-syms", baseline, find_library())

    def test_the_library_exports_what_its_header_declares_and_nothing_else(self):
        listed = self.run_ok("nm", "-D", "--defined-only", find_library()).stdout.split()[2::3]
        names = {name.partition("@@")[0]: name.partition("@@")[2] for name in listed}
        names.pop("UNLATCH_0.1", None)  # the symbol of the version itself
        self.assertEqual(set(names), list_declared())
        self.assertEqual(set(names.values()), {"UNLATCH_0.1"})

    def test_the_abi_is_that_of_the_last_release(self):
        done = self.compare(BASELINE)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_a_change_of_the_abi_is_found(self):
        text = BASELINE.read_text(encoding="utf-8")
        removed, narrower = self.folder / "removed.abi", self.folder / "narrower.abi"
        removed.write_text(text.replace("unlatch_step", "unlatch_stride"), encoding="utf-8")
        self.assertTrue(self.compare(removed).returncode & INCOMPATIBLE)
        size = re.search(r"<class-decl name='unlatch_event' size-in-bits='(\d+)'", text)
        self.assertEqual(size[1], "192")
        moved = text.replace("layout-offset-in-bits='128'", "layout-offset-in-bits='96'")
        self.assertNotEqual(moved, text)
        narrower.write_text(moved, encoding="utf-8")
        self.assertNotEqual(self.compare(narrower).returncode, 0)

    def test_enumerators_keep_their_numbers(self):
        released = ENUMERATORS.read_text(encoding="utf-8").split("\n")[:-1]
        self.assertGreater(len(released), 40)
        for line in released:
            self.assertIn(line, list_enumerators())

    def test_examples_build_from_the_installed_tree_and_give_the_hash_of_a_session(self):
        if SANITIZED:
            self.skipTest("a library with a sanitizer needs programs with the same one")
        prefix, log = self.folder / "prefix", self.folder / "session.log"
        self.run_ok("cmake", "--install", BUILD, "--prefix", prefix, "--component", "library")
        prefix = prefix.rename(self.folder / "moved")  # it may be moved before its use
        examples = self.folder / "examples"
        self.run_ok("cmake", "-S", SOURCE / "library/examples", "-B", examples, f"-DCMAKE_PREFIX_PATH={prefix}",
                    f"-DCMAKE_C_COMPILER={CC}", f"-DCMAKE_CXX_COMPILER={CXX}", "-DCMAKE_C_FLAGS=-Wall -Wextra -Wpedantic -Werror",
                    "-DCMAKE_CXX_FLAGS=-Wall -Wextra -Wpedantic -Werror")
        self.run_ok("cmake", "--build", examples)
        session = self.run_json(BIN / "unlatch", "hil", BOOSTERS, "--transport", "inproc", "--pace", "lockstep", "--until", "2",
                                "--log", log, code=None)
        self.assertEqual(session["ticks"], 2000)
        own = self.run_ok(examples / "separate", BOOSTERS).stdout
        self.assertIn(f"hash {session['hash']}", own)
        self.assertEqual(len(re.findall(r"^\d\.\d{6} s  liftoff booster", own, re.M)), 4)
        self.assertIn(f"2000 ticks, hash {session['hash']}", self.run_ok(examples / "follow", BOOSTERS, log).stdout)
        self.assertEqual(self.run_ok(examples / "dispersion", REFERENCE).stdout.count("has a margin of"), 10)
        # Uses pkg-config in place of CMake, as C99.
        found = subprocess.run(["pkg-config", "--cflags", "--libs", "unlatch"], capture_output=True, text=True, check=True,
                               env={**os.environ, "PKG_CONFIG_PATH": str(next(prefix.glob("lib*/**/pkgconfig")))}).stdout.split()
        library = next(prefix.glob("lib*/**/libunlatch.so")).parent
        self.run_ok(CC, "-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Werror", SOURCE / "library/examples/separate.c", "-o",
                    self.folder / "by_pkg_config", *found, f"-Wl,-rpath,{library}")
        self.assertEqual(self.run_ok(self.folder / "by_pkg_config", BOOSTERS).stdout, own)


if __name__ == "__main__":
    main()
