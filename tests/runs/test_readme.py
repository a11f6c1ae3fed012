"""The README's first steps, word for word: its files written, its commands run in a shell, in their order.

In place of `make run` stands what it runs, for a shorter time and without a process for each component; what sets up an
environment and what opens a window is left out.
"""

import os
import re
import shutil
import signal
import socket
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

ROOT = Path(__file__).parents[2]
LEFT_OUT = ("source ", "towline view ")
LIMIT_S = 120.0  # of all the commands


def first_steps() -> str:
    return re.search(r"^## First steps\n(.*?)^## ", (ROOT / "README.md").read_text(), re.DOTALL | re.MULTILINE).group(1)


def test_first_steps(tmp_path):
    text = first_steps()
    files = dict(re.findall(r"`(\S+\.(?:py|yaml))`:\n\n```\w+\n(.*?)```\n", text, re.DOTALL))
    text = re.sub(r"```\w+\n.*?```\n", "", text, flags=re.DOTALL)
    assert files.keys() == {"spring.py", "spring.yaml"}
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    shutil.copytree(ROOT / "scenarios", tmp_path / "scenarios")
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        port = str(one.getsockname()[1])
    lines = [line for block in re.findall(r"```\n(.*?)```", text, re.DOTALL) for line in block.splitlines() if line]
    assert "$(BIN)/towline run $(SCENARIO)" in (ROOT / "Makefile").read_text()
    made = "towline run scenarios/dp_rov_tether.yaml --until 20s"
    commands = [made if line.startswith("make run") else line for line in lines if not line.startswith(LEFT_OUT)]
    changed = [re.sub(r"(scenarios/\S+ .*) --until", r"\1 --bus local --until", line) for line in commands]
    script = "\n".join(["set -eu", *changed, "kill $!"]).replace("7447", port)
    environment = os.environ | {"PATH": f"{Path(sys.executable).parent}:{os.environ['PATH']}"}
    shell = subprocess.Popen(
        ["bash", "-c", script],
        cwd=tmp_path,
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    try:
        told, _ = shell.communicate(timeout=LIMIT_S)
    finally:
        with suppress(ProcessLookupError):  # what is left of them: the host, where a command failed
            os.killpg(shell.pid, signal.SIGKILL)
    assert shell.returncode == 0, f"{script}\n{told[-3000:]}"
    assert {"report.html", "stronger.mcap", "spring.fmu", "far.mcap"} <= {path.name for path in tmp_path.iterdir()}
