"""Both distances between rewards: pseudometrics that scale, offset and shaping do not change."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from harness.payoff.rollout import Rollout, record_rollouts
from harness.reach import ReachTask
from harness.registry.choice import choose
from harness.registry.registry import load_registry
from harness_plugins.audit.distance import DARD, EPIC, SHAPING, compare_forms, distance_between
from harness_plugins.audit.scripts import anywhere, canonical_values, forms_of_distances, nearby
from harness_plugins.kit import IdealSimulator
from harness_plugins.rewards.arp import Arp
from harness_plugins.rewards.baseline import Baseline

REGISTRY = load_registry()
GAMMA = 0.95
NAMES = REGISTRY.names("rewards")
COVERAGES = {EPIC: anywhere, DARD: nearby}


def build(name):
    """A registered reward with its defaults."""
    return choose(REGISTRY, "rewards", name).build(REGISTRY, "rewards")


@pytest.fixture(scope="module")
def short(robot):
    """Rollouts of short episodes: pairs of rewards are many."""
    return record_rollouts(IdealSimulator(), robot, ReachTask(horizon=30), 8)


def reward_distance(one, other, rollouts, form):
    """In one canonical form; None where it is not defined."""
    return distance_between(*(forms_of_distances(reward, rollouts, GAMMA)[form] for reward in (one, other)))


@pytest.fixture(scope="module", params=COVERAGES)
def form(request):
    """What makes the difference between the two distances."""
    return request.param


@pytest.fixture(scope="module")
def between(short, form):
    """The distance of two rewards, or None."""
    return lambda one, other: reward_distance(one, other, short, form)


@pytest.fixture(scope="module")
def changed(toolbox):
    """The baseline times a factor, plus an offset and shaping by a potential."""

    def change(factor, offset=0.0, phi=lambda distance: 0.0 * distance):
        def value(sample):
            shaping = GAMMA * phi(sample.distance) - phi(sample.previous_distance)
            return factor * Baseline()((), sample)[1] + offset + shaping

        return toolbox.paying(value)

    return change


@pytest.mark.parametrize("name", NAMES)
def test_no_distance_to_itself(between, name):
    """Every reward is at 0 from itself, exactly."""
    assert between(build(name), build(name)) == 0.0


@settings(max_examples=6)
@given(st.floats(0.01, 100.0))
def test_scale_does_not_count(between, changed, factor):
    """A positive factor changes nothing."""
    assert between(changed(factor), Baseline()) == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=6)
@given(st.floats(-10.0, 10.0))
def test_an_offset_does_not_count(between, changed, offset):
    """A constant per step changes nothing."""
    assert between(changed(1.0, offset), Baseline()) == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=6)
@given(st.floats(-5.0, 5.0), st.floats(-5.0, 5.0))
def test_shaping_does_not_count(between, changed, slope, bend):
    """A potential of the distance changes nothing."""
    shaped = changed(1.0, 0.0, lambda distance: slope * distance + bend * np.sin(3.0 * distance))
    assert between(shaped, Baseline()) == pytest.approx(0.0, abs=1e-9)


def test_the_opposite_is_farthest(between, changed):
    """A negative factor gives 1."""
    assert between(changed(-1.0), Baseline()) == pytest.approx(1.0)


def test_the_order_does_not_count(between):
    """Whatever the rewards, the distance is symmetric, and in [0, 1] where there is one."""
    rewards = [build(name) for name in NAMES]
    for one, other in itertools.pairwise([*rewards, rewards[0]]):
        value = between(one, other)
        assert value == between(other, one)
        assert value is None or 0.0 <= value <= 1.0


def test_a_detour_is_no_shorter(between, toolbox):
    """The triangle inequality."""
    rewards = [Baseline(), Arp(), toolbox.relative, toolbox.dense, toolbox.counting()]
    apart = np.array([[between(one, other) for other in rewards] for one in rewards])
    assert (apart[:, None, :] <= apart[:, :, None] + apart[None, :, :] + 1e-12).all()


def test_other_rewards_are_apart(between, toolbox):
    """ARP differs from the baseline, and the relative gain differs more."""
    assert 0.01 < between(Arp(), Baseline()) < between(toolbox.relative, Baseline())


def test_shaping_alone_is_at_no_distance(between, toolbox):
    """Canonically shaped, a potential is constant: it correlates with nothing, and equals another one."""
    assert between(toolbox.potential(GAMMA), Baseline()) is None
    assert between(toolbox.potential(GAMMA), toolbox.potential(GAMMA, lambda distance: distance**2)) == 0.0


def test_the_distance_is_pearsons(rollouts, form):
    """sqrt((1 - rho) / 2), with rho from numpy."""
    values = [canonical_values(reward, rollouts, GAMMA, COVERAGES[form])[0] for reward in (Arp(), Baseline())]
    rho = np.corrcoef(*values)[0, 1]
    found = reward_distance(Arp(), Baseline(), rollouts, form)
    assert found == pytest.approx(np.sqrt((1.0 - rho) / 2.0))


def test_all_running_steps_count(rollouts, form):
    """What is compared is every step of every episode, and none after its end."""
    found = forms_of_distances(Arp(), rollouts, GAMMA)[form]
    assert len(found) == sum(int(rollout.steps.sum()) for rollout in rollouts)


def test_what_has_no_distance_says_why():
    """Whose form is missing, or that one of the two is constant; two constants are the same."""
    some, constant, missing = np.array([1.0, 0.0]), None, "it is odd"
    assert compare_forms("a", {EPIC: some}, "b", {EPIC: missing}) == {EPIC: "b: it is odd"}
    assert compare_forms("a", {EPIC: some}, "b", {EPIC: constant}) == {EPIC: SHAPING}
    assert compare_forms("a", {EPIC: constant}, "b", {EPIC: constant}) == {EPIC: 0.0}


@settings(max_examples=6)
@given(st.floats(0.1, 5.0), st.floats(0.1, 5.0))
def test_dard_also_cancels_potentials_of_the_step_and_the_begin(short, toolbox, slope, bend):
    """They are the same after two steps from s and from s'. EPIC's last term is a constant, which leaves them in."""

    def shaped(sample):
        before, after = (
            slope * sample.begin_distance * distance + bend * np.sqrt(step)
            for distance, step in (
                (sample.previous_distance, sample.step - 1.0), (sample.distance, sample.step),
            )
        )  # fmt: skip
        return Baseline()((), sample)[1] + GAMMA * after - before

    epic, dard = (reward_distance(toolbox.paying(shaped), Baseline(), short, form) for form in (EPIC, DARD))
    assert dard == pytest.approx(0.0, abs=1e-9)
    assert epic > 1e-3


def test_dard_does_not_ask_about_steps_that_cannot_be_done(toolbox):
    """A reward that differs only in jumps no arm makes is the same to DARD, and another to EPIC."""

    def jumping(sample):
        jump = np.abs(sample.distance - sample.previous_distance) > 0.1
        return Baseline()((), sample)[1] + np.where(jump, sample.previous_distance**2, 0.0)

    rng = np.random.default_rng(0)
    changes = rng.uniform(-0.02, 0.02, (20, 40))
    distances = np.vstack([np.zeros(40), np.cumsum(changes, axis=0)]) + np.linspace(0.5, 2.0, 40)
    made = [Rollout("made", {"distance": distances}, 0.0 * changes, np.ones(changes.shape, bool), np.zeros(40, bool))]
    reward = toolbox.paying(jumping)
    assert reward_distance(reward, Baseline(), made, DARD) == pytest.approx(0.0, abs=1e-9)
    assert reward_distance(reward, Baseline(), made, EPIC) > 0.1
