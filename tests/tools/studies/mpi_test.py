#!/usr/bin/env python3
"""Facts about `unlatch-mpi`: campaigns on several ranks give the results of `unlatch campaign`, also when ranks fail.

    mpi_test.py BIN_FOLDER SOURCE_FOLDER [unittest options]
"""

import json
import os
import re
import shutil
import signal
import struct
import subprocess
import time

from processes import BIN, HANG, SCENARIOS, UNLATCH, ProcessTest, call, main

PROGRAM = str(BIN / "unlatch-mpi")
CAMPAIGN = str(SCENARIOS / "boosters/campaign.yaml")
SHORT = ["--set", "step.until=0.2"]  # no joint opens by then
# A body that turns for 5 steps. At a rate of 1e200 rad/s its first step fails.
TOP = """unlatch: 1
name: top
step: {dt: 0.01, until: 0.05}
bodies:
  top: {mass: 2, inertia: [1, 2, 2.5], rate: [0, 1, 0]}
  base: {mass: 1000, inertia: [9, 9, 9]}
requirements:
  - {id: fast, text: it is slow, velocity: {body: top, relative_to: base}, at_most: 2.5}
"""
# Samples enough for each rank to get some, even if it begins late.
MANY = "set: {step.until: 8 s}\nsamples: 200\nparameters:\n  m: {path: bodies.top.mass, uniform: {min: 1, max: 3}}\n"
# Each rank writes its process number to a file for the test.
NUMBERED = 'echo $$ > "$0/$OMPI_COMM_WORLD_RANK.pid"; exec "$@"'


def describe_missing():
    if not os.path.exists(PROGRAM):
        return "unlatch-mpi is not built: MPI is missing (tools/setup test)"
    return None if shutil.which("mpirun") else "there is no mpirun (tools/setup test)"


class MpiTest(ProcessTest):
    def setUp(self):
        super().setUp()
        # Permission for root; more ranks than processors; messages between processes only by shared memory.
        self.environment = {**os.environ, "OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
                            "OMPI_MCA_rmaps_base_oversubscribe": "1", "OMPI_MCA_hwloc_base_binding_policy": "none",
                            "OMPI_MCA_btl": "self,vader", "OMPI_MCA_btl_vader_single_copy_mechanism": "none",
                            "OMPI_MCA_btl_vader_backing_directory": str(self.folder)}

    def build_command(self, ranks, *arguments):
        return ["mpirun", "-n", str(ranks), "bash", "-c", NUMBERED, str(self.folder), PROGRAM, *map(str, arguments)]

    def mpirun(self, command):
        return subprocess.run(command, capture_output=True, text=True, timeout=HANG, env=self.environment)

    def run_ranks(self, ranks, *arguments, code=0):
        done = self.mpirun(self.build_command(ranks, *arguments))
        self.assertEqual(done.returncode, code, done.stdout[-2000:] + done.stderr[-4000:])
        return done

    def run_campaign(self, ranks, path, out, *options, code=0):
        return json.loads(self.run_ranks(ranks, "campaign", path, "--out", self.folder / out, "--json", "-", *options, code=code).stdout)

    def run_alone(self, path, out, *options, code=0):
        return json.loads(self.run_ok(UNLATCH, "campaign", path, "--out", self.folder / out, "--json", "-", *options, code=code).stdout)

    def write(self, rest, name="c.yaml"):
        (self.folder / "top.yaml").write_text(TOP)
        path = self.folder / name
        path.write_text("unlatch_campaign: 1\nname: c\nscenario: top.yaml\n" + rest)
        return path

    def check_same_tables(self, one, other):
        for name in ("samples.csv", "samples.parquet", "manifest.json"):
            if (self.folder / one / name).exists():  # without Node.js there is no Parquet
                self.assertEqual((self.folder / one / name).read_bytes(), (self.folder / other / name).read_bytes(), name)

    def write_long(self):
        """Writes a campaign with minutes of samples."""
        return self.write("set: {step.until: 8 s}\nsamples: 100000\nparameters:\n"
                          "  m: {path: bodies.top.mass, uniform: {min: 1, max: 3}}\n"
                          "  w: {path: 'bodies.top.rate[0]', uniform: {min: -1, max: 1}}\n")

    def begin_and_wait_for_samples(self, path, out, count, *options):
        """Starts a job; returns in mid-run, when it has this number of samples and far more to do."""
        process = subprocess.Popen(self.build_command(3, "campaign", path, "--out", self.folder / out, *options),
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env=self.environment)

        def end():
            if process.poll() is None:
                process.terminate()  # mpirun ends its ranks
                process.wait(timeout=HANG)
            process.stderr.close()

        self.addCleanup(end)
        results = self.folder / out / "results.bin"
        before = results.stat().st_size if results.exists() else 0
        limit = time.monotonic() + HANG
        while not results.exists() or results.stat().st_size < before + count * 200:  # bytes of a record, fewer than it has
            self.assertIsNone(process.poll(), "it ended")
            self.assertLess(time.monotonic(), limit)
            time.sleep(0.01)
        return process

    def send(self, rank, which):
        os.kill(int((self.folder / f"{rank}.pid").read_text()), which)

    def test_ranks_give_the_table_and_hash_of_one_thread(self):
        alone = self.run_alone(CAMPAIGN, "alone", *SHORT, "--samples", "3:40", "--jobs", "1", code=1)
        ranks = self.run_campaign(3, CAMPAIGN, "ranks", *SHORT, "--samples", "3:40", code=1)
        self.assertEqual(alone["hash"], ranks["hash"])
        self.assertEqual(alone["samples"], 37)
        self.check_same_tables("alone", "ranks")

    def test_threads_of_ranks_and_one_rank_alone_change_nothing(self):
        path = self.write("samples: 500\nsampling: latin-hypercube\nparameters:\n  m: {path: bodies.top.mass, uniform: {min: 1, max: 3}}\n")
        alone = self.run_alone(path, "alone")
        self.assertEqual(alone["hash"], self.run_campaign(2, path, "threads", "--jobs", "3")["hash"])
        self.assertEqual(alone["hash"], self.run_campaign(1, path, "one")["hash"])
        self.check_same_tables("alone", "threads")
        self.check_same_tables("alone", "one")

    def test_rare_failures_are_the_same_on_ranks(self):
        path = self.write("sampling: subset\nsamples: 100\nsubset: {of: fast}\nparameters:\n" + "".join(
            f"  v{k}: {{path: 'bodies.top.velocity[{k}]', normal: {{mean: 0 m/s, sigma: 0.6 m/s}}}}\n" for k in range(3)))
        alone = self.run_alone(path, "alone", "--jobs", "1")
        self.assertGreater(len(alone["rare"]["levels_run"]), 2)
        ranks = self.run_campaign(3, path, "ranks", "--jobs", "2")
        self.assertEqual(alone["hash"], ranks["hash"])
        self.assertEqual(alone["rare"], ranks["rare"])
        self.check_same_tables("alone", "ranks")

    def list_samples(self, out):
        """Lists samples in the order of the result file; an incomplete record at its end is left out."""
        manifest = json.loads((self.folder / out / "manifest.json").read_text())
        record = 40 + 8 * (len(manifest["inputs"]) + len(manifest["columns"])) + 120 + 8  # bytes
        content = (self.folder / out / "results.bin").read_bytes()[32:]
        return [struct.unpack_from("<q", content, at)[0] for at in range(0, len(content) - record + 1, record)]

    def test_killed_ranks_end_the_job_which_resumes_to_the_same_hash(self):
        path = self.write_long()
        first = self.begin_and_wait_for_samples(path, "killed", 9)
        self.send(2, signal.SIGKILL)
        self.assertNotEqual(first.wait(timeout=HANG), 0)
        second = self.begin_and_wait_for_samples(path, "killed", 9, "--resume")
        self.send(0, signal.SIGKILL)
        self.assertNotEqual(second.wait(timeout=HANG), 0)
        kept = self.list_samples("killed")
        shutil.copytree(self.folder / "killed", self.folder / "other")
        every = ["--samples", f"0:{max(kept) + 8}"]
        hashes = {self.run_alone(path, "alone", *every)["hash"],
                  self.run_alone(path, "other", *every, "--resume")["hash"],
                  self.run_campaign(3, path, "killed", *every, "--resume")["hash"]}
        self.assertEqual(len(hashes), 1)
        self.check_same_tables("alone", "killed")
        self.check_same_tables("alone", "other")
        self.assertEqual(self.list_samples("killed")[:len(kept)], kept)  # complete samples are not run again
        self.assertEqual(sorted(self.list_samples("killed")), list(range(max(kept) + 8)))

    def test_a_rank_told_to_end_ends_all_in_order(self):
        process = self.begin_and_wait_for_samples(self.write_long(), "out", 4)
        self.send(1, signal.SIGTERM)
        self.assertEqual(process.wait(timeout=HANG), 1)
        self.assertIn("interrupted; --resume continues", process.stderr.read())
        summary = json.loads((self.folder / "out/summary.json").read_text())
        self.assertGreaterEqual(summary["samples"], 4)

    def test_a_sample_that_faults_is_a_result(self):
        path = self.write("samples: 60\nparameters:\n  w: {path: 'bodies.top.rate[0]', discrete: {values: [0, 1e200]}}\n")
        alone = self.run_alone(path, "alone", code=1)
        ranks = self.run_campaign(3, path, "ranks", code=1)
        self.assertGreater(ranks["statuses"]["faulted"], 10)
        self.assertGreater(ranks["statuses"]["done"], 10)
        self.assertEqual(alone["hash"], ranks["hash"])
        self.check_same_tables("alone", "ranks")

    def test_a_mistake_is_reported_once_with_exit_code_2(self):
        path = self.write("samples: 4\nparameters:\n  m: {path: bodies.top.mas, uniform: {min: 1, max: 2}}\n")
        expected = call(UNLATCH, "campaign", path, "--out", self.folder / "alone")
        done = self.run_ranks(3, "campaign", path, "--out", self.folder / "out", code=2)
        self.assertEqual(done.stderr.count(expected.stderr.strip()), 1, done.stderr)
        self.assertFalse((self.folder / "out").exists())
        unknown = self.run_ranks(3, "campaign", path, "--ou", self.folder / "out", code=2)
        self.assertEqual(unknown.stderr.count("there is no option '--ou'"), 1, unknown.stderr)
        merge = self.run_ranks(3, "campaign", "merge", "a", "--out", self.folder / "out", code=2)
        self.assertEqual(merge.stderr.count("unlatch campaign merge"), 1, merge.stderr)

    def test_help_and_version_are_printed_once(self):
        self.assertEqual(self.run_ranks(3, "campaign", "--help").stdout.count("--samples"), 1)
        page = self.folder / "unlatch-mpi.1"
        self.run_ok(PROGRAM, "--manual", page)  # without mpirun, for the build
        self.assertIn("mpirun", page.read_text())
        self.assertRegex(self.run_ok(PROGRAM, "--version").stdout, r"^unlatch-mpi \d")

    def run_beside(self, path, *other, code):
        """Runs rank 0 with this file, rank 1 with another program; returns standard error."""
        done = self.mpirun(["mpirun", "-n", "1", PROGRAM, "campaign", str(path), "--out", str(self.folder / "out"), ":", "-n", "1",
                            *map(str, other)])
        self.assertEqual(done.returncode, code, done.stderr)
        return done.stderr

    def run_unlike(self, here, there, code):
        return self.run_beside(here, PROGRAM, "campaign", there, "--out", self.folder / "out", code=code)

    def test_a_rank_that_reads_another_file_ends_the_job(self):
        text = "samples: 900\nparameters:\n  m: {path: bodies.top.mass, uniform: {min: 1, max: 3}}\n"
        stderr = self.run_unlike(self.write(text), self.write(text + "seed: 2\n", "other.yaml"), 3)
        self.assertEqual(stderr.count("rank 1 reads another campaign or scenario than rank 0"), 1, stderr)

    def test_bytes_that_are_not_of_the_protocol_end_the_job(self):
        path = self.write(MANY)
        for mode, printed in (("hello", "began with a message of no known kind"), ("twice", "began with a message of no known kind"),
                           ("version", "is another version of unlatch-mpi"), ("jobs", "no possible number of threads"),
                           ("size", "sent 1000000 bytes"), ("kind", "sent a message of no known kind"),
                           ("bye", "sent a message after its last one"), ("record", "no record of a sample"),
                           ("short", "no record of a sample"), ("sample", "sample 205, which it was not given"),
                           ("again", "which it was not given"), ("inputs", "with other inputs than it was given")):
            with self.subTest(mode):
                stderr = self.run_beside(path, BIN / "mpi_stranger", mode, path, code=3)
                self.assertEqual(len(re.findall(f"^rank 1 .*{printed}", stderr, re.M)), 1, stderr)
                shutil.rmtree(self.folder / "out")

    def test_a_foreign_rank_that_keeps_to_the_protocol_changes_nothing(self):
        path = self.write(MANY)  # enough samples that the foreign messages, and nothing else, end the job
        alone = self.run_alone(path, "alone")["hash"]
        self.run_beside(path, BIN / "mpi_stranger", "honest", path, code=0)
        self.assertEqual(json.loads((self.folder / "out/summary.json").read_text())["hash"], alone)

    def test_a_rank_that_cannot_read_its_file_says_so(self):
        good = self.write("samples: 4\nparameters:\n  m: {path: bodies.top.mass, uniform: {min: 1, max: 3}}\n")
        stderr = self.run_unlike(good, self.folder / "none.yaml", 2)
        self.assertRegex(stderr, r"rank 1 on \S+: .*none\.yaml")

    def test_a_full_disk_ends_it_with_an_error_and_a_readable_file(self):
        path = self.write("samples: 2000\nparameters:\n  m: {path: bodies.top.mass, uniform: {min: 1, max: 3}}\n")
        small = self.folder / "small"
        small.mkdir()
        script = f"mount -t tmpfs -o size=64k none {small} || exit 77; \"$@\"; code=$?; cp -r {small} {self.folder}/kept; exit $code"
        command = self.build_command(3, "campaign", path, "--out", small / "out")
        done = self.mpirun(["unshare", "-m", "bash", "-c", script, "bash", *command])
        if done.returncode == 77 or "unshare: " in done.stderr:
            self.skipTest("this machine allows no mount")
        self.assertEqual(done.returncode, 3, done.stderr)
        self.assertEqual(done.stderr.count("results.bin: it cannot be written"), 1, done.stderr)
        merged = self.run_ok(UNLATCH, "campaign", "merge", self.folder / "kept/out", "--out", self.folder / "read", "--json", "-", code=1)
        self.assertGreater(json.loads(merged.stdout)["samples"], 10)

    def test_unlatch_itself_needs_no_mpi(self):
        files = [UNLATCH, *(BIN.parent / "lib").glob("**/unlatch/*.so")]
        for file in files:
            self.assertNotIn("libmpi", self.run_ok("ldd", file).stdout, file)
        self.assertIn("libmpi", self.run_ok("ldd", PROGRAM).stdout)  # the test detects it if it is there


if __name__ == "__main__":
    if reason := describe_missing():
        print(f"mpi_test.py: {reason}")
        raise SystemExit(77)
    main()
