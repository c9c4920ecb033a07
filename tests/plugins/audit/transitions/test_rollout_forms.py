"""Distances of rewards that read more than distances: asked about recorded states and actions of an arm."""

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harness.payoff.rollout import record_rollouts, score_rollout
from harness.reward.forms import reward_class
from harness.task import ReachTask
from harness_plugins.audit.distance import FORMS, compare_forms
from harness_plugins.audit.transitions.rollout_forms import ask_of, forms_of_rollouts, rows_of_rollouts
from harness_plugins.kit import IdealSimulator
from tests.payoff.conftest import named

GAMMA = 0.95


def gentle(step):
    """Reach the target, and move little."""
    return {
        "reach": -step.distance,
        "effort": -0.01 * (step.action**2).sum(-1),
        "jerk": -0.1 * ((step.action - step.before.action) ** 2).sum(-1),
    }


def phi(distance):
    """Some potential of the distance."""
    return np.sin(5.0 * distance) - 3.0 * distance


def shaped(step):
    """The same three times, with an offset and shaping by the potential."""
    terms = {name: 3.0 * value for name, value in gentle(step).items()}
    return {**terms, "shaping": GAMMA * phi(step.distance) - phi(step.before.distance), "offset": 0.0 * step.step + 2.0}


def restless(step):
    """Pays for motion."""
    return (step.qvel**2).sum(-1) - step.distance


class Counting:
    """Pays the action, and more with every step that came nearer."""

    def initial_carry(self, begin_distance):
        """No step so far."""
        return np.zeros_like(begin_distance)

    def __call__(self, carry, step):
        """One more where it is nearer."""
        count = carry + (step.distance < step.previous_distance)
        return count, step.action[:, 0] * count


GENTLE, DENSE = reward_class(gentle)(), named("dense")


@pytest.fixture(scope="module")
def rollouts(robot):
    """Four short episodes of each script."""
    return record_rollouts(IdealSimulator(), robot, ReachTask(horizon=25), 4)


@pytest.fixture(scope="module")
def distances(rollouts):
    """The distances of two rewards by form."""

    def distances(one, other, gamma=GAMMA):
        return compare_forms(
            "one", forms_of_rollouts(one, rollouts, gamma), "other", forms_of_rollouts(other, rollouts, gamma)
        )

    return distances


def test_scale_and_potential_shaping_are_no_distance(distances):
    """In all three forms; an offset is none either."""
    assert distances(GENTLE, reward_class(shaped)()) == pytest.approx(dict.fromkeys(FORMS, 0.0), abs=1e-9)


def test_a_weight_changes_the_distance(distances):
    """The more effort counts, the farther it is from the distance alone."""
    near, far = (distances(reward_class(gentle)(effort=weight), DENSE)["EPIC"] for weight in (1.0, 50.0))
    assert near < far


@pytest.mark.parametrize("reward", [GENTLE, reward_class(restless)(), Counting()], ids=["terms", "plain", "memory"])
def test_asked_about_its_own_steps_a_reward_pays_what_it_paid(rollouts, reward):
    """Whatever it reads and remembers, in every step of every script."""
    rows = rows_of_rollouts(rollouts)
    ask, begin, lengths = ask_of(reward, rollouts, rows), 0, iter(rows.lengths)
    for rollout in rollouts:
        values = score_rollout(reward, rollout).values
        for episode in range(rollout.running.shape[1]):
            length = next(lengths)
            steps = begin + np.arange(length)
            assert length == rollout.steps[episode]
            assert_array_equal(ask(steps, steps, steps + 1), values[:length, episode])
            begin += length + 1
    assert not [*lengths]


def test_what_is_asked_of_a_step_that_nobody_took(rollouts):
    """The state before is whole, and the one after it too; the action is a third step's."""
    rows, seen = rows_of_rollouts(rollouts), []

    def look(step):
        seen.append(step)
        return 0.0 * step.action[:, 0]

    first = len(rows.numbers) - rows.lengths[-1] - 1  # of the last episode
    s, a, after = ([first + 7], [3], [41])
    ask_of(reward_class(look)(), rollouts, rows)(*map(np.array, (s, a, after)))
    step, columns = seen[-1], rows.columns
    for name in ("qpos", "qvel", "end_effector", "target", "distance", "ground"):
        assert (getattr(step, name) == columns[name][after]).all()
        assert (getattr(step.before, name) == columns[name][s]).all()
    assert (step.action == columns["action"][[4]]).all()
    assert (step.before.action == columns["action"][s]).all()
    assert step.previous_distance == columns["distance"][s]
    assert step.begin_distance == columns["distance"][first]
    assert step.delta_distance == step.distance - columns["distance"][first : first + 8].min()
    assert step.step == 8.0


def test_a_number_that_is_not_finite_is_a_reason(distances):
    """A reward that pays no number for a jump, which no arm makes."""

    def broken(step):
        return np.where(np.abs(step.distance - step.previous_distance) > 0.25, np.nan, step.action[:, 0])

    found = distances(GENTLE, reward_class(broken)())["EPIC"]
    assert (
        found
        == "other: asked about another step than the one taken, it pays a number that is not finite, or beyond 1e+150"
    )


def test_starc_needs_a_discount(distances):
    """Without one the value of a state has no bound; the other forms do without."""
    found = distances(GENTLE, DENSE, 1.0)
    assert "discount below 1" in found["STARC"]
    assert isinstance(found["EPIC"], float)
