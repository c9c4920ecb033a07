"""What a run would do, before it does."""

from dataclasses import replace

import pytest

from harness.cli.progress import foreseen_lines
from harness.experiment.experiment import check, prepare
from harness.experiment.foresee import foresee
from harness.experiment.plan import check_experiment
from harness.experiment.run_options import RunOptions
from tests.refusals import refused

ASKED = {"sim": "ideal", "algo": "wander", "reward": "arp", "seeds": 2, "steps": 12, "evaluation_episodes": 2}


def ready(out, asked=ASKED, **options):
    """A run that is checked and has written nothing."""
    return check(check_experiment(asked), RunOptions(out=out, executor="here", **options))


def test_nothing_is_written(toys, tmp_path):
    """Not even the folder."""
    found = foresee(ready(tmp_path / "mine"))
    assert (found.is_new, len(found.done), len(found.to_do), found.left) == (True, 0, 4, 0)
    assert found.seconds is None
    assert "no cell of ideal · wander is done" in found.unknown
    assert list(tmp_path.iterdir()) == []


def test_what_is_done_and_what_is_left(toys, tmp_path):
    """Time and disk come from the done cells."""
    out = tmp_path / "mine"
    prepare(check_experiment({**ASKED, "seeds": 1}), RunOptions(out=out, executor="here")).run()
    found = foresee(ready(out, jobs=1, limit=1))
    assert (found.is_new, len(found.done), len(found.to_do), found.left) == (False, 2, 1, 1)
    assert found.to_do[0].seed == 1
    both = foresee(ready(out, jobs=1))
    assert both.bytes == pytest.approx(2 * found.bytes)
    assert both.seconds == pytest.approx(2 * found.seconds)
    assert foresee(ready(out, jobs=2)).seconds == pytest.approx(found.seconds)
    assert found.memory > 0


def test_memory_is_told_where_it_is_large(toys, tmp_path):
    """Of all cells that are at work at once."""
    found = foresee(ready(tmp_path / "mine", jobs=2))
    assert not any("Memory" in line for line in foreseen_lines(replace(found, memory=10**9 - 1)))
    told = [line for line in foreseen_lines(replace(found, memory=3_800_000_000)) if "Memory" in line]
    assert told == ["Memory: about 3.8 GB, 2 at once, estimated from the done cells"]


def test_what_no_cell_did_is_measured(tmp_path):
    """By a few steps in another folder; what is written stays unknown."""
    asked = {"task": "gymnasium:id=Pendulum-v1", "algo": "random", "seeds": 4, "steps": 2_000}
    found = foresee(check(check_experiment(asked), RunOptions(out=tmp_path / "mine", jobs=1)), measures=True)
    assert found.seconds > 0.0
    assert found.measured > 0
    assert (found.horizon, found.bytes) == (200, None)
    told = "\n".join(foreseen_lines(found))
    assert f"1 at once, by {found.measured:,} steps measured here just now\n" in told
    assert "episodes of each policy, each of at most 200 steps\n" in told
    assert list(tmp_path.iterdir()) == []


def test_another_machine_is_not_measured(toys, tmp_path):
    """What trains elsewhere takes other times than this machine."""
    found = foresee(ready(tmp_path / "mine"), measures=True)
    assert found.seconds is None
    assert "is done in the folder yet, and the executor here trains elsewhere. --only " in found.unknown


def test_an_environment_without_a_horizon_is_cut(tmp_path):
    """That is said, and nothing else."""
    asked = {"task": "gymnasium:id=Pendulum-v1", "algo": "random", "seeds": 1}
    found = foresee(check(check_experiment(asked), RunOptions(out=tmp_path / "mine")))
    assert "each cut after 10,000 steps if it goes on so long" in "\n".join(foreseen_lines(found))


def test_what_cannot_work_has_its_reason(toys, tmp_path):
    """As the run will say."""
    found = foresee(ready(tmp_path, {**ASKED, "algo": "wander,buttons", "task": "fd100-reach:action=discrete"}))
    assert {reason for _, reason in found.skipped} == {"wander takes continuous actions, the task's are discrete"}
    assert {cell.algorithm.name for cell in found.to_do} == {"buttons"}


def test_foreign_folder_is_refused(toys, tmp_path):
    """As the run would refuse it."""
    (tmp_path / "thesis.txt").write_text("all of it")
    with refused("holds something else"):
        ready(tmp_path)
