"""Which files of `harness` and `plugins` a command enters, and how often it goes back to one.

A file is entered when a function in it is called. What runs at import, modules, class bodies and decorators, and what
they call, does not count. A hop is a call from one of our files to another: Python's and other libraries' frames
between them are looked through. Each pair of files counts once. A hop goes back if the process had entered the other
file before. The processes that a command starts count: their files, hops and ways back are united with its own.
"""

import json
import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from tests.architecture.source import ROOT

OURS = (ROOT / "harness", ROOT / "plugins")
TRACER = Path(__file__).parent / "tracer"
LEAST = ("--seeds", "1", "--steps", "120", "--jobs", "1", "--evaluation-episodes", "2")
COMMANDS = {
    "run of an arm": ("run", "--sim", "mujoco", "--algo", "sac", *LEAST),
    "run of Pendulum": (
        *("run", "--task", "gymnasium:id=Pendulum-v1", "--baseline", "none", "--reward", "own", "--algo", "sac"),
        *LEAST,
    ),
    "eta of CSV files": ("eta", "--baseline", "base*.csv", "--proposed", "new*.csv"),
    "report of an experiment": ("report", "done"),
    "report of Monitor files": ("report", "logs", "--measure", "return"),
    "audit of a reward": ("audit", "--reward", "arp"),
}
"""By name, what `harness` is called with, in a folder that has the files."""
BEFORE = {
    "report of an experiment": ("run", "--sim", "kinematic", "--algo", "random", *LEAST, "--out", "done"),
}
"""What is called before, and does not count."""


@dataclass(frozen=True)
class Entered:
    """What a command went through, by the names of files from the repository's root."""

    files: frozenset[str]
    hops: frozenset[tuple[str, str]]
    back: frozenset[tuple[str, str]]
    loaded: frozenset[str]
    """Those that were imported, entered or not."""


def enter(arguments, folder, tops=(ROOT / "harness", ROOT / "plugins")):
    """Run Python with these arguments in a folder, and see what it enters of the folders in `tops`.

    Raises:
        RuntimeError: The command failed; with what it said.
    """
    into = folder / "entered"
    into.mkdir()
    path = os.pathsep.join(filter(None, [str(TRACER), os.environ.get("PYTHONPATH")]))
    told = {
        "PYTHONPATH": path,
        "ENTERED_INTO": str(into),
        "ENTERED_TOPS": os.pathsep.join(f"{top}{os.sep}" for top in tops),
    }
    environment = {**os.environ, **told}
    command = [sys.executable, *arguments]
    ended = subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)
    if ended.returncode:
        raise RuntimeError(ended.stdout + ended.stderr)
    files = set()
    hops = set()
    back = set()
    loaded = set()
    root = tops[0].parent
    for process in sorted(into.iterdir()):
        seen = json.loads(process.read_text())
        name = {file: Path(file).relative_to(root).as_posix() for file in [*seen["files"], *seen["loaded"]]}
        files |= {name[file] for file in seen["files"]}
        loaded |= {name[file] for file in seen["loaded"]}
        hops |= {(name[caller], name[called]) for caller, called in seen["hops"]}
        back |= {(name[caller], name[called]) for caller, called in seen["back"]}
    return Entered(frozenset(files), frozenset(hops), frozenset(back), frozenset(loaded))


def enter_harness(command, folder):
    """Run one of `COMMANDS` in a new folder."""
    (folder / "logs").mkdir()
    for number in range(3):
        for name, more in (("base", 0.0), ("new", 0.2)):
            paid = [0.1 * number - 0.5 + (0.01 + more) * step for step in range(100)]
            rows = {
                "csv": ["reward", *paid],
                "monitor.csv": ['#{"t_start": 0.0}', "r,l,t", *(f"{it},{number + 9},{it}" for it in paid)],
            }
            for end, lines in rows.items():
                file = folder / ("logs" if end == "monitor.csv" else ".") / f"{name}_{number}.{end}"
                file.write_text("\n".join([*map(str, lines), ""]))
    if command in BEFORE:
        subprocess.run([sys.executable, "-m", "harness", *BEFORE[command]], cwd=folder, check=True, capture_output=True)
    out = ("--out", "out") if command.startswith("run") else ()
    return enter(["-m", "harness", *COMMANDS[command], *out], folder)


def measured_by_running(folder, commands=COMMANDS):
    """Every figure, by its name in `bounds.toml`; what the commands write goes into folders in this one."""
    figures = {}
    for number, command in enumerate(commands):
        (inner := folder / str(number)).mkdir()
        entered = enter_harness(command, inner)
        figures[f"files entered, {command}"] = len(entered.files)
        figures[f"hops between files, {command}"] = len(entered.hops)
        figures[f"hops back to a file, {command}"] = len(entered.back)
    return figures
