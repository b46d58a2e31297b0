"""Builds the wheel: pip wheel --no-build-isolation --no-deps library/python, or python3 setup.py bdist_wheel.

The contents come from CMake: from the build folder in the variable UNLATCH_BUILD, else from one that is built here. The wheel
contains libunlatch.so and needs yaml-cpp of the system."""

import os
import re
import shutil
import subprocess
from pathlib import Path

from setuptools import Distribution, setup
from setuptools.command.build_py import build_py

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
VERSION = re.search(r"^project\(unlatch VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"), re.M)[1]


class Build(build_py):
    """Takes the package from CMake."""

    def run(self):
        build = os.environ.get("UNLATCH_BUILD")
        if not build:
            subprocess.run([ROOT / "tools/build", "release", "--target", "unlatch_python"], check=True)
            build = ROOT / "build/release"
        target = Path(self.build_lib).resolve()
        shutil.rmtree(target / "unlatch", ignore_errors=True)
        subprocess.run(["cmake", "--install", build, "--prefix", target, "--component", "wheel"], check=True)
        if shutil.which("strip"):  # a fifth of the size
            subprocess.run(["strip", "--strip-unneeded", *target.glob("unlatch/*.so*")], check=True)


class Binary(Distribution):
    """A wheel for this platform."""

    def has_ext_modules(self):
        return True


setup(name="unlatch", version=VERSION, description="Simulation of structures that separate and deploy", packages=["unlatch"],
      python_requires=">=3.9", install_requires=["numpy"], cmdclass={"build_py": Build}, distclass=Binary)
