"""Models compiled side by side, in a cache of their own: all of them are there afterwards, also where a helper dies."""

import os
import subprocess
import sys

import pytest

NAMES = ("motion.fixed", "motion.van_der_pol", "winch.drum")
SCRIPT = """
import os, subprocess, sys
from pathlib import Path
from components.compiled import is_cached
from pipeline import catalogue, compilation

os.sched_getaffinity = lambda _: {0, 1}
if sys.argv[1] == "killed":
    start = subprocess.Popen
    def popen(*arguments, **options):
        helper = start(*arguments, **options)
        helper.kill()
        return helper
    subprocess.Popen = popen
names = sys.argv[2:]
compilation.compile_side_by_side([*names, "a model of one's own"])
print(*(name for name in names if is_cached(catalogue.find(name, Path())[1])))
"""


@pytest.mark.parametrize("helper", ["lives", "killed"])
def test_all_are_in_the_cache(helper, tmp_path):
    environment = os.environ | {"TOWLINE_CACHE": str(tmp_path)}
    command = [sys.executable, "-c", SCRIPT, helper, *NAMES]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=120, check=True)
    assert done.stdout.split() == list(NAMES)
