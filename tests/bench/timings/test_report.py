"""Reports of many cells: what they take beside reading their files, and beside a report of few cells."""

import json
import statistics
import sys

import pytest

from harness import load_registry, run
from harness.record import DERIVED
from tests.bench.timings.processes import measure
from tests.copied_cells import copy_experiment, keep_as_a_run_does, many_rewards

FOLDERS = {"one combination": (["arp"], 100), "fifty": (many_rewards(49), 4)}
SPEED, MEMORY = 0.09, 0.4
UNKEPT_SECONDS, UNKEPT_MEGABYTES = 100.0, 800.0
"""Of CPU time, and of memory, that the first report of 1,000 cells of 55,000 steps may take."""
READ = """
import hashlib, pathlib, sys
for path in pathlib.Path(sys.argv[1]).rglob("*"):
    if path.is_file():
        with path.open("rb") as file:
            hashlib.file_digest(file, "sha256")
"""
"""What a report does besides: no file may have changed."""


def report(folder):
    """In a process of its own."""
    return measure(sys.executable, "-c", "from harness.cli.app import main; main()", "report", folder, "--json")


def copies(tmp_path, steps, proposed, seeds, executor, *, kept=True):
    """Of four trainings under each of two rewards; of each copy that is kept which a run keeps, or nothing."""
    run(
        out=tmp_path / "real", sim="kinematic", algo="random", robot="unity-arm", task="arp-2021", seeds=4, steps=steps,
        evaluation_episodes=2, jobs=2, executor=executor,
    )  # fmt: skip
    registry = load_registry()
    copy_experiment(tmp_path / "real", tmp_path / "copies", proposed, seeds, registry)
    if kept:
        keep_as_a_run_does(tmp_path / "copies", registry)
    return tmp_path / "copies"


def test_copies_are_compared(toys, tmp_path):
    """Every reward with the baseline over all seeds, split by what the other would have paid."""
    folder = copies(tmp_path, 300, many_rewards(2), 6, "here")
    for combination in json.loads(report(folder).out)["combinations"]:
        assert combination["seeds"] == list(range(6))
        assert combination["eta_P"]["paths"]
    assert len(list((folder / DERIVED).iterdir())) == 18


@pytest.mark.slow
@pytest.mark.bench
@pytest.mark.parametrize("name", FOLDERS)
def test_report_of_many_cells(tmp_path, require_ratio, name):
    """Of 20,000 steps each, however they are put together: CPU time beside reading, memory beside that of 8 cells."""
    folder = copies(tmp_path, 20_000, *FOLDERS[name], "processes")
    turns = [(measure(sys.executable, "-c", READ, folder), report(folder)) for _ in range(3)]
    few = min(report(tmp_path / "real").megabytes for _ in range(2))
    many = turns[-1][1]
    assert len(json.loads(many.out)["cells"]) == 200
    ratio = statistics.median(reading.cpu_seconds / reported.cpu_seconds for reading, reported in turns)
    require_ratio(ratio, SPEED, f"(report {many.cpu_seconds:.1f} s)", "time")
    require_ratio(few / many.megabytes, MEMORY, f"({many.megabytes:.0f} MB)", "memory")


@pytest.mark.slow
@pytest.mark.bench
def test_first_report_of_a_thousand_cells(tmp_path, require_ratio):
    """Where nothing is kept, as of a folder that was merged: it reads all traces, and holds one at a time."""
    folder = copies(tmp_path, 55_000, ["arp"], 500, "processes", kept=False)
    first = report(folder)
    assert len(json.loads(first.out)["cells"]) == 1000
    assert report(folder).out == first.out
    require_ratio(UNKEPT_SECONDS / first.cpu_seconds, 1.0, f"(report {first.cpu_seconds:.0f} s)", "time")
    require_ratio(UNKEPT_MEGABYTES / first.megabytes, 1.0, f"({first.megabytes:.0f} MB)", "memory")
