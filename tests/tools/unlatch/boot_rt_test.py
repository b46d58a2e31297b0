#!/usr/bin/env python3
"""A PREEMPT_RT kernel with the parameters of hil/REALTIME.md, in QEMU: boot_rt_test.py BIN SOURCE BUILD. No time in there means anything."""

import importlib.machinery
import importlib.util
import sys
import types
import unittest
from pathlib import Path

BIN, SOURCE, BUILD = (Path(sys.argv.pop(1)).resolve() for _ in range(3))
SKIPPED = 77

loader = importlib.machinery.SourceFileLoader("boot_rt", str(SOURCE / "tools/boot-rt"))
sys.dont_write_bytecode = True
boot_rt = importlib.util.module_from_spec(importlib.util.spec_from_loader("boot_rt", loader))
loader.exec_module(boot_rt)


class BootRtTest(unittest.TestCase):
    def test_the_parameters_that_it_boots_are_those_of_the_page(self):
        page = (SOURCE / "hil/REALTIME.md").read_text(encoding="utf-8")
        for word in boot_rt.PARAMETERS.split():
            self.assertIn(word.split("=")[0] + "=", page)

    def test_a_session_in_real_time_passes_on_an_isolated_cpu_of_a_preempt_rt_kernel(self):
        try:
            text = boot_rt.boot(types.SimpleNamespace(bin=BIN, build=BUILD, until="0.6"))
        except boot_rt.Missing as what:
            self.skipTest(str(what))
        steps = boot_rt.read_steps(text)
        self.assertEqual(list(steps), list(boot_rt.STEPS), text[-3000:])
        for name, (code, said) in steps.items():
            self.assertEqual(code, 0, f"{name}: {said[-2000:]}")
        preflight = steps["preflight"][1]
        self.assertRegex(preflight, r"good +kernel: .*PREEMPT_RT")
        self.assertRegex(preflight, r"good +isolated CPUs: 1, tickless 1")
        self.assertRegex(preflight, r"good +locked memory")
        self.assertRegex(preflight, r"good +real-time priority")
        fix = steps["fix"][1]  # nothing of what the boot has mended
        self.assertIn("#!/bin/sh", fix)
        self.assertNotIn("linux-image-rt-amd64", fix)
        self.assertNotIn("isolcpus", fix)
        self.assertEqual(steps["interrupts"][1].strip(), "1")  # of CPU 0 alone
        self.assertIn("boosters: ok, 600 ticks", steps["session"][1])
        self.assertIn("every bit agrees at all 601 ticks", steps["replay"][1])


if __name__ == "__main__":
    result = unittest.main(verbosity=2, exit=False).result
    sys.exit(1 if not result.wasSuccessful() else SKIPPED if result.skipped else 0)
