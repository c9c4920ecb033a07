"""Reports of many cells: what they take, of copies of a few trainings."""

import json
import sys
from pathlib import Path

import pytest

from harness.experiment.experiment import run
from harness.record.folder import DERIVED
from harness.registry.registry import load_registry
from tests.bench.timings.processes import Taken, measure
from tests.copied_cells import copy_experiment, keep_as_a_run_does, many_rewards

CPU_SECONDS, MEGABYTES = 12.0, 1_000.0
"""Of a report over 1,000 cells of 55,000 steps; measured are 7 to 10 s on a busy machine, and 380 MB."""
FOLDERS = {"one combination": (["arp"], 500), "fifty": (many_rewards(49), 20)}


def report(folder: Path) -> Taken:
    """In a process of its own."""
    return measure(sys.executable, "-c", "from harness.cli.app import main; main()", "report", folder, "--json")


def copies(tmp_path: Path, steps: int, proposed: list[str], seeds: int, executor: str) -> Path:
    """Of four trainings under each of two rewards."""
    run(
        out=tmp_path / "real", sim="kinematic", algo="random", robot="unity-arm", task="arp-2021", seeds=4, steps=steps,
        evaluation_episodes=2, jobs=2, executor=executor,
    )  # fmt: skip
    registry = load_registry()
    copy_experiment(tmp_path / "real", tmp_path / "copies", proposed, seeds, registry)
    keep_as_a_run_does(tmp_path / "copies", registry)
    return tmp_path / "copies"


@pytest.mark.usefixtures("toys")
def test_copies_are_compared(tmp_path: Path):
    """Every reward with the baseline over all seeds, split by what the other would have paid."""
    folder = copies(tmp_path, 300, many_rewards(2), 6, "here")
    for combination in json.loads(report(folder).out)["combinations"]:
        assert combination["seeds"] == list(range(6))
        assert combination["eta_P"]["paths"]
    assert len(list((folder / DERIVED).iterdir())) == 18


@pytest.mark.slow
@pytest.mark.bench
@pytest.mark.parametrize("name", FOLDERS)
def test_report_of_a_thousand_cells(tmp_path: Path, name: str):
    """So many CPU seconds and so much memory, however the cells are put together."""
    taken = report(copies(tmp_path, 55_000, *FOLDERS[name], "processes"))
    assert len(json.loads(taken.out)["cells"]) == 1_000
    assert taken.cpu_seconds < CPU_SECONDS, f"{taken.cpu_seconds:.1f} s"
    assert taken.megabytes < MEGABYTES, f"{taken.megabytes:.0f} MB"
