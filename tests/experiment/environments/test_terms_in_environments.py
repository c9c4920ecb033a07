"""A reward of terms in an environment: planned, tried, trained with weights, compared by its columns."""

import re

import numpy as np
import pytest

import harness
from harness import load_registry, load_results
from harness.experiment.trials.tried_plan import try_plan
from harness.record import read_recording
from harness.registry import read_given
from harness.reward.terms import sum_of
from harness.score.weighted_recordings import weighed
from tests.experiment.environments.test_reward_files import PENDULUM, plan_of
from tests.record.recording.told import terms_of
from tests.refusals import refused

GENTLE = """
def gentle(step):
    \"\"\"Stand upright, and push little.\"\"\"
    push = clip(step.action) - step.before.action
    return {"upright": step.observation[0], "effort": -0.1 * (step.action**2).sum(-1), "jerk": -0.1 * abs(push[0])}


def clip(x):
    return x.clip(-1.0, 1.0)
"""


@pytest.fixture
def gentle(tmp_path):
    """A file with the reward and a helper function."""
    (tmp_path / "gentle.py").write_text(GENTLE)
    return tmp_path / "gentle.py"


def test_weights_of_terms_make_rewards(gentle):
    """Several in a list; a weight of 1 changes nothing, and terms stand in their own order."""
    plan = plan_of(gentle, reward="gentle,gentle:jerk=2,effort=5,gentle:effort=1,gentle:effort=0.05", baseline="own")
    labels = ["own", "gentle", "gentle:effort=5,jerk=2", "gentle:effort=0.05"]
    assert [cell.reward.label for cell in plan.cells] == labels
    assert plan.cells[2].reward.params == (("effort", 5.0), ("jerk", 2.0))
    others = [{"name": "gentle", "effort": 5.0, "jerk": 2.0}, {"name": "gentle", "effort": 0.05}]
    assert plan.resolved["reward"] == ["gentle", *others]
    assert plan_of(gentle, **{key: plan.resolved[key] for key in ("reward", "baseline")}).cells == plan.cells


REFUSED = {
    "a term that is none": (
        "gentle:efort=5",
        "has no term 'efort' to weigh. It has: upright, effort, jerk. Did you me",
    ),
    "no number": ("gentle:effort=much", "is no weight: give a number from -1e+18 to 1e+18, as in gentle:effort=5"),
    "what is infinite": ("gentle:effort=inf", "is no weight"),
    "a reward without terms": ("own:effort=5", "takes no parameters, since it pays no terms"),
    "a helper function": ("clip", "In gentle.py, clip(x) is no reward: a reward or a measure takes (step)"),
}


@pytest.mark.parametrize(("reward", "told"), REFUSED.values(), ids=REFUSED)
def test_what_cannot_be_weighed_is_refused(gentle, reward, told):
    """With what there is."""
    with refused(re.escape(told)):
        plan_of(gentle, reward=reward)


@pytest.mark.parametrize(
    ("body", "told"),
    [
        ("-step.distance", "fails in step 0: A step has no 'distance'. It has: observation, action, info, terminated"),
        ("step.info['x_pos']", "fails in step 0: info has no 'x_pos'; it has nothing. Nothing"),
        ("step.before.info['x_pos']", "info has no 'x_pos'"),
    ],
)
def test_what_is_not_there_is_told_before_a_run(tmp_path, body, told):
    """By its name, with what there is."""
    (tmp_path / "far.py").write_text(f"def far(step):\n    return {body}\n")
    plan = plan_of(tmp_path / "far.py", reward="far", baseline="own")
    with refused(re.escape(told)):
        try_plan(plan, load_registry(given=read_given([tmp_path / "far.py"])))


@pytest.fixture(scope="module")
def trained(tmp_path_factory):
    """An experiment with and without weights."""
    folder = tmp_path_factory.mktemp("trained")
    (folder / "gentle.py").write_text(GENTLE)
    harness.run(
        task=PENDULUM, algo="random", plugins=[folder / "gentle.py"], seeds=2, steps=210, evaluation_episodes=1,
        reward="gentle,gentle:effort=5", baseline="own", out=folder / "runs", jobs=1,
    )  # fmt: skip
    return folder / "runs"


def test_trainings_and_evaluations_have_terms(trained):
    """Whoever was trained: their sum is the pay, to the last bit."""
    results = load_results(trained)
    for cell in results.done_cells:
        for name in ("training", "evaluation"):
            found = read_recording(results.store.cell_folder(cell) / name)
            assert np.array_equal(sum_of(terms_of(found, "gentle")), found["reward/gentle"])
            assert found.facts.trained_with == cell.reward.label


def test_columns_pay_what_other_weights_pay(trained):
    """In the run that was trained so, and in the others, by which they are compared."""
    results = load_results(trained)
    label = "gentle:effort=5"
    for cell in results.done_cells:
        found = read_recording(results.store.cell_folder(cell) / "training")
        terms = terms_of(found, "gentle")
        expected = terms["upright"] + 5.0 * terms["effort"] + terms["jerk"]
        recorded = found if cell.reward.label == label else weighed(found, [label])
        assert np.abs(recorded[f"reward/{label}"] - expected).max() <= 1e-12
    (trainings,) = results.trainings
    assert set(trainings.read.rewards) == {"own", "gentle", label}
    assert all(run.episodes.knows(label) for run in trainings.runs.values())
    assert [it.proposed for it in results.combinations] == ["gentle", label]
    assert all(mean.value is not None for it in results.returns for mean in it.returns[label].values())
    heavy = next(it for it in results.terms if it.reward == label)
    assert [it.name for it in heavy.terms] == ["upright", "effort", "jerk"]
    assert all(it.others.value is not None and it.random is not None for it in heavy.terms)
