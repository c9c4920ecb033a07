"""Evaluations of cells in environments: along the budget, in both manners, of random actions, of the null control."""

from pathlib import Path

import pytest

from harness import load_registry, run
from harness.experiment.plan import expand, read_experiment
from harness.record import EXPERIMENT, RANDOM, read_recording
from harness.record.folder import evaluation_files, recording_of
from harness.registry import read_given
from harness.results.ranking import ranking_of
from tests.refusals import refused

HERE = Path(__file__).parent
TOLD = {"task": "toy", "algo": "random", "steps": 64, "seeds": 2, "evaluation_episodes": 3, "jobs": 1}


def _run(out, **given):
    return run(**{**TOLD, "plugins": [HERE / "toy.py"], "out": out, **given})


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """The baseline twice, and another reward; evaluated on the way."""
    folder = tmp_path_factory.mktemp("evaluated") / "out"
    return _run(folder, algo="sac-fast:learning_starts=8,batch_size=4,net_arch=4", reward="near,near,right",
                evaluate_every=20)  # fmt: skip


def test_policies_are_evaluated_while_they_learn(results):
    """After so many steps, as the recordings say."""
    for cell in results.plan.cells:
        found = evaluation_files(results.store.cell_folder(cell), suffix="")
        assert list(found) == [20, 40, 60]
        assert [read_recording(path).facts.after for path in found.values()] == [20, 40, 60]


def test_evaluations_on_the_way_change_no_training(results, tmp_path):
    """The same steps with and without."""
    without = _run(tmp_path / "out", algo="sac-fast:learning_starts=8,batch_size=4,net_arch=4", reward="right")
    one, other = (
        next(it for it in of.plan.cells if (it.reward.label, it.seed) == ("right", 0)) for of in (results, without)
    )
    ways = [of.store.cell_folder(cell) / "training" for of, cell in ((results, one), (without, other))]
    assert (read_recording(ways[0])["reward/right"] == read_recording(ways[1])["reward/right"]).all()


@pytest.mark.parametrize("deterministic", [True, False])
def test_policies_are_evaluated_in_both_manners(tmp_path, deterministic):
    """The recordings say how they acted."""
    found = _run(tmp_path / "out", deterministic=deterministic, seeds=1)
    folder = found.store.cell_folder(found.plan.cells[0])
    other = recording_of("stochastic.parquet" if deterministic else "deterministic.parquet")
    own = recording_of("deterministic.parquet" if deterministic else "stochastic.parquet")
    assert read_recording(folder / "evaluation").facts.acted == own
    assert read_recording(folder / other).facts.acted == other


def test_random_actions_are_evaluated_once(results):
    """For all cells of an environment."""
    folders = [results.store.cell_folder(cell) / recording_of(RANDOM) for cell in results.plan.cells]
    assert sum(folder.is_dir() for folder in folders) == 1


def test_random_actions_stand_beside_the_policies(results):
    """In every measure of both manners."""
    found = results.combinations[0]
    changes = found.measured.changes_of(found.manner)
    assert [change.name for change in changes] == ["success", "distance"]
    assert all(change.random is not None for change in changes)


def test_the_measure_that_decides_is_compared_along_the_budget(results):
    """At each evaluation before the end; and how fast the trainings learned."""
    found = results.combinations[0]
    assert [moment.steps for moment in found.measured.along] == [20, 40, 60]
    assert [change.name for change in found.measured.changes_of("while learning")] == ["success_area", "steps_to_goal"]


def test_the_null_control_is_compared_alone(results):
    """The baseline against itself with other seeds; its claims correct no others."""
    *others, control = results.combinations
    assert (control.is_control, [it.is_control for it in others]) == (True, [False])
    assert control.seeds == (0, 1)
    assert control.number.decomposition.total.ruler.value == pytest.approx(0.0)


def test_the_null_control_alone_is_an_experiment(tmp_path):
    """Named twice, or as the baseline and the proposed reward."""
    for number, given in enumerate(({"reward": "near,near"}, {"reward": "near", "baseline": "near"})):
        (found,) = _run(tmp_path / str(number), **given).combinations
        assert found.is_control


def test_the_experiment_file_asks_for_the_control_too(results):
    """So the same experiment is repeated from it."""
    registry = load_registry(given=read_given([HERE / "toy.py"]))
    again = expand(read_experiment(results.folder / EXPERIMENT, {}), registry)
    assert (again.cells, again.control) == (results.plan.cells, {0: 2, 1: 3})


@pytest.fixture(scope="module")
def of_two(tmp_path_factory):
    """Two rewards in two environments."""
    return _run(tmp_path_factory.mktemp("two") / "out", task=["toy", "toy:discrete=true"])


def test_several_environments_are_one_matrix(of_two):
    """Each has its comparisons, and all are one family of claims."""
    assert [it.group.task.label for it in of_two.combinations] == ["toy", "toy:discrete=True"]
    assert len({it.answer.claims for it in of_two.combinations}) == 1


def test_rewards_are_ranked_over_environments(of_two):
    """By the measure that decides; each environment has a vote of its own."""
    (ranking,) = ranking_of(of_two).tasks
    assert [place.simulator for place in ranking.places] == ["toy", "toy:discrete=True"]
    assert ranking.rewards == ("near", "right")
    assert ranking.votes("simulator") == ("toy", "toy:discrete=True")


def test_tasks_of_an_arm_do_not_go_with_environments(tmp_path):
    """In one line; nothing is written."""
    with refused("some are tasks of an arm, some environments"):
        _run(tmp_path / "out", task=["toy", "fd100-reach"], sim="kinematic")
    assert not (tmp_path / "out").exists()


def test_several_tasks_of_an_arm_are_one_matrix(tmp_path):
    """Each with its comparison; all are one family."""
    tasks = ["fd100-reach:horizon=5", "fd100-reach:horizon=6"]
    found = _run(tmp_path / "out", task=tasks, sim="kinematic", reward="arp", steps=12)
    assert [it.group.task.label for it in found.combinations] == tasks
    assert len({it.answer.claims for it in found.combinations}) == 1
