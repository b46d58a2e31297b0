#!/usr/bin/env python3
"""The counters that tools/cost --natively puts into assembly add exactly the instructions that are executed, and change
nothing else. Skipped (77) on other processors than x86-64."""

import importlib.machinery
import importlib.util
import platform
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[3]

# Sums 1 … n: 7 instructions and 3 in each of n turns. `clear`: 4, and one for each of 8 words.
SUM = """
\t.text
\t.globl\tsum
sum:
\txorl\t%eax, %eax
\ttestq\t%rdi, %rdi
\tje\t.L2
.L1:
\taddq\t%rdi, %rax
\tdecq\t%rdi
\tjne\t.L1
.L2:
\tpushq\t%rax
\tcall\tclear
\tpopq\t%rax
\tret
clear:
\tleaq\t-80(%rsp), %rdi
\tmovl\t$8, %ecx
\txorl\t%eax, %eax
\trep stosq
\tret
\t.section\t.note.GNU-stack,"",@progbits
"""
MAIN = """
#include <stdio.h>
unsigned long target_counter, target_saved;
long sum(long n);
int main(void) {
  for (long n = 0; n < 3; ++n) {
    target_counter = 0;
    const long got = sum(n);
    printf("%ld %lu\\n", got, target_counter);
  }
  return 0;
}
"""


def load_cost():
    loader = importlib.machinery.SourceFileLoader("cost", str(ROOT / "tools/cost"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader("cost", loader))
    loader.exec_module(module)
    return module


def main():
    if platform.machine() != "x86_64":
        print("skipped: no x86-64")
        return 77
    cost = load_cost()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "sum.s").write_text(cost.add_counters(SUM))
        (folder / "main.c").write_text(MAIN)
        subprocess.run(["gcc", "-no-pie", "-o", folder / "sum", folder / "main.c", folder / "sum.s"], check=True)
        got = subprocess.run([folder / "sum"], capture_output=True, text=True, check=True).stdout.split()
    turns = lambda n: 3 + 3 * n + 4 + 3 + 8 + 1
    expected = [str(number) for n in range(3) for number in (n * (n + 1) // 2, turns(n))]
    if got != expected:
        print(f"sums and instructions {got} instead of {expected}")
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
