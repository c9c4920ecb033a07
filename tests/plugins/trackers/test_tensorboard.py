"""Event files for TensorBoard."""

import subprocess
import sys

import pytest

from harness_plugins.trackers.tensorboard import TensorBoard

pytest.importorskip("tensorboard", reason="needs the extra tensorboard")


def test_numbers_are_read_back(tracked, read_events):
    """By name, with their steps, of a cell that goes on too, and before it ends."""
    for steps in (100, 200):
        track = TensorBoard().begin(tracked)
        track.log(steps, {"Losses/Policy Loss": 0.5, "Policy/Entropy": float(steps)})
    [folder] = (tracked.folder / "tensorboard").iterdir()
    assert read_events(folder) == {
        "Losses/Policy Loss": [(100, 0.5), (200, 0.5)],
        "Policy/Entropy": [(100, 100.0), (200, 200.0)],
    }
    track.end("done", "")


def test_the_folder_is_named_for_people_and_for_one_cell(tracked):
    """By title and id."""
    TensorBoard().begin(tracked).end("done", "")
    [folder] = (tracked.folder / "tensorboard").iterdir()
    assert folder.name == f"ideal_wander_baseline_seed_0-{tracked.id}"


def test_no_library_is_imported_before_a_cell_begins():
    """``harness describe`` stays quick."""
    code = "import sys; from harness_plugins.trackers import tensorboard, wandb; tensorboard.TensorBoard()"
    check = "assert not {'tensorboard', 'wandb'} & set(sys.modules)"
    subprocess.run([sys.executable, "-c", f"{code}; {check}"], check=True)
