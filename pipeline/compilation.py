"""Compilation of models side by side: each is taken by the next process that is free, into the cache that all share."""

from __future__ import annotations

import gc
import os
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from pipeline import catalogue
from pipeline.hosts.death import die_with

MOST = 4  # processes: each holds some 300 MB while it compiles
LIMIT_S = 600.0  # that a process may go on after this one has found nothing left to do


def compile_side_by_side(names: Iterable[str]) -> None:
    """Compile those of the catalogue's models that are not in the cache, the largest first.

    What does not compile, or a process that ends early, is left to whoever binds that model next, and tells of it.
    """
    from components.compiled import is_cached  # with numba, which not every command needs

    fresh = [name for name in {*names} & {*catalogue.models()} if not is_cached(_component(name))]
    jobs = sorted(fresh, key=_size, reverse=True)
    processes = min(len(os.sched_getaffinity(0)), len(jobs), MOST)
    if processes < 2:
        return
    queue, end = os.pipe()
    os.write(end, bytes(range(len(jobs))))
    os.close(end)
    command = [sys.executable, "-P", "-m", "pipeline.compilation", str(os.getpid()), str(queue), *jobs]
    quiet = subprocess.DEVNULL
    helpers = [
        subprocess.Popen(command, stdin=quiet, stdout=quiet, stderr=quiet, pass_fds=[queue])
        for _ in range(processes - 1)
    ]
    try:
        _work(queue, jobs)
        for helper in helpers:
            helper.wait(LIMIT_S)
    finally:
        os.close(queue)
        for helper in helpers:
            helper.kill()
            helper.wait()


def _work(queue: int, jobs: list[str]) -> None:
    """Compile what the queue, a byte a job, still holds: a byte is read by one process only."""
    from components.compiled import bind

    while job := os.read(queue, 1):
        gc.disable()  # a tenth of the compiler's time, for garbage that goes with the job
        try:
            bind(_component(jobs[job[0]]))
        except Exception:  # numba's are of many kinds; whoever binds it next tells
            continue
        finally:
            gc.enable()
            gc.collect()


def _component(name: str):
    return catalogue.find(name, Path())[1]


def _size(name: str) -> int:
    """Bytes of a model's own sources: what its compilation takes, roughly."""
    folder = Path(sys.modules[_component(name).init.__module__].__file__ or "").parent
    return sum(path.stat().st_size for path in folder.glob("*.py"))


if __name__ == "__main__":
    if not die_with(int(sys.argv[1])):
        sys.exit()
    _work(int(sys.argv[2]), sys.argv[3:])
