"""Functions of a step as rewards of an experiment: what its traces keep, and what its manifests tell."""

import pytest
from numpy.testing import assert_array_equal

import harness
from harness.record import EVALUATION, TRACE, read_manifest, read_trace

SLOW = '''
def slow(step):
    """Reach the target slowly."""
    return {"reach": -step.distance, "speed": -0.01 * abs(step.qvel).sum(-1)}
'''


@pytest.fixture
def run(tmp_path):
    """Run in one folder: the baseline, and what is asked for."""
    (tmp_path / "slow.py").write_text(SLOW)

    def run(*rewards):
        asked = {"sim": "kinematic", "algo": "random", "seeds": 2, "steps": 300, "jobs": 1}
        return harness.run(
            **asked, evaluation_episodes=2, reward=list(rewards), plugins=[tmp_path / "slow.py"], out=tmp_path / "out"
        )

    return run


def folder_of(results, cell):
    """Where a cell left its files."""
    return results.store.cell_folder(cell)


def test_every_training_keeps_what_a_reward_reads(run):
    """Also the baseline's, so that the reward can pay it."""
    results = run("slow", "slow:speed=3")
    for cell in results.done_cells:
        for file in (TRACE, EVALUATION):
            assert read_trace(folder_of(results, cell) / file)["qvel"].shape[1] == 6


def test_a_training_has_a_column_of_each_term(run):
    """With its weight; their sum is the pay."""
    results = run("slow", "slow:speed=3")
    plain, heavy = (
        read_trace(folder_of(results, cell) / TRACE)
        for label in ("slow", "slow:speed=3")
        for cell in results.done_cells
        if (cell.reward.label, cell.seed) == (label, 0)
    )
    assert_array_equal(heavy["reward/speed"], 3.0 * plain["reward/speed"])
    assert_array_equal(heavy["reward/reach"] + heavy["reward/speed"], heavy["reward"])


def test_the_manifest_tells_what_is_read_and_paid(run):
    """Of a reward of distances nothing: its manifests are what they were."""
    results = run("slow")
    told = {
        cell.reward.label: read_manifest(folder_of(results, cell)).environment.get("reward")
        for cell in results.done_cells
    }
    assert told == {"baseline": None, "slow": {"reads": ["distance", "qvel"], "terms": ["reach", "speed"]}}


def test_an_experiment_may_grow_by_a_reward_that_reads_more(run):
    """Trainings that are done stay done: what their traces lack is said, and the rest is compared."""
    before = {cell.id for cell in run("arp").done_cells}
    results = run("arp", "slow")
    assert before < {cell.id for cell in results.done_cells}
    (slow,) = (it for it in results.combinations if it.proposed == "slow")
    assert slow.number.splits["eta_N"].ruler.note == (
        "reward slow reads qvel, which these trainings did not record; new ones with it do"
    )
