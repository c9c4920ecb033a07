"""A value that a reward never reads changes no figure of it; one that it reads costs that episode, which is told."""

import h5py
import numpy as np
import pytest

from harness.payoff.dataset.arm_pay import of_arm
from harness.payoff.dataset.paid_dataset import pay_dataset
from harness.payoff.dataset.rewards import Recorded
from harness.payoff.dataset.step_by_step import step_by_step
from harness.score.places import parse_places
from tests.payoff.conftest import named
from tests.plugins.audit.dataset.test_dataset_audit import reaching
from tests.record.dataset.written import opened, write_lerobot, write_minari

COUNT, TORN, STEP = 8, 3, 2
READS = {"recorded": "rewards", "moved": "actions", **dict.fromkeys(("seen", "left", "reaches"), "observations")}


def write_d4rl(path, episodes):
    """One file, in which episodes stand one behind the other."""
    with h5py.File(path, "w") as file:
        for key in ("observations", "actions", "rewards"):
            file[key] = np.concatenate([one[key][: len(one["rewards"])] for one in episodes])
        ends = np.concatenate([np.arange(len(one["rewards"])) == len(one["rewards"]) - 1 for one in episodes])
        file["terminals"], file["timeouts"] = np.zeros(len(ends), bool), ends


def write_robomimic(path, episodes):
    """A group for each demonstration."""
    with h5py.File(path, "w") as file:
        for number, one in enumerate(episodes):
            demo = file.create_group(f"data/demo_{number}")
            demo["obs/state"], demo["actions"] = one["observations"][:-1], one["actions"]
            demo["rewards"], demo["dones"] = one["rewards"], np.arange(len(one["rewards"])) == len(one["rewards"]) - 1


WRITERS = {"minari": write_minari, "lerobot": write_lerobot, "d4rl": write_d4rl, "robomimic": write_robomimic}


def paid(format_, place, episodes):
    """What every kind of reward pays a data set of these episodes."""
    WRITERS[format_](place, episodes)
    key = "state" if format_ == "robomimic" else ""
    places = parse_places(f"end_effector={key}[0:3],target={key}[3:6]" if key else "end_effector=0:3,target=3:6")

    def seen(step):
        observation = step.observation["state"] if key else step.observation
        return float(observation[0] > 0.5)  # NaN is not above it, and is no failure

    def left(step):
        return seen(step.before)

    rewards = {
        "recorded": Recorded("recorded"),
        "seen": step_by_step("seen", seen),
        "left": step_by_step("left", left),
        "reaches": of_arm(named("sparse"), places),
        "moved": step_by_step("moved", lambda step: float(step.action[0])),
    }
    return pay_dataset(opened(f"{format_}:{place}"), rewards)


def with_blank(key, step):
    """Episodes, one of which has no number there."""
    episodes = [reaching(number) for number in range(COUNT)]
    episodes[TORN] = {name: np.copy(it) if isinstance(it, np.ndarray) else it for name, it in episodes[TORN].items()}
    episodes[TORN][key][step] = np.nan
    return episodes


@pytest.mark.parametrize("blank", ["rewards", "observations", "actions"])
@pytest.mark.parametrize("format_", WRITERS)
def test_a_blank_costs_the_episode_for_those_rewards_that_read_it(format_, blank, tmp_path):
    """In every format, and for recorded pay, functions and an arm's reward alike."""
    whole = paid(format_, tmp_path / "whole", [reaching(number) for number in range(COUNT)])
    torn = paid(format_, tmp_path / "torn", with_blank(blank, STEP))
    assert len(torn) == len(whole) == COUNT
    for name, reads in READS.items():
        if reads == blank:
            assert np.flatnonzero(torn.lost[name]).tolist() == [TORN], name
        else:
            assert not torn.lost[name].any(), name
            assert np.array_equal(torn.paid[name], whole.paid[name], equal_nan=True), name


@pytest.mark.parametrize("format_", WRITERS)
def test_a_blank_before_the_first_step_costs_that_episode_alone(format_, tmp_path):
    """For who reads it: what was seen after the steps is whole."""
    torn = paid(format_, tmp_path / "torn", with_blank("observations", 0))
    assert np.flatnonzero(torn.lost["left"]).tolist() == [TORN]
    assert not torn.lost["seen"].any()


def test_a_reward_that_looks_at_what_no_episode_tells_pays_none_and_is_told(tmp_path):
    """Episodes of one step each, in a format that keeps what was seen before a step alone."""
    episodes = map(reaching, range(COUNT))
    write_d4rl(
        tmp_path / "d", [{key: it[key][:1] for key in ("observations", "actions", "rewards")} for it in episodes]
    )
    found = pay_dataset(opened(f"d4rl:{tmp_path / 'd'}"), {"next": step_by_step("next", _of_next)})
    assert "looks at what came after a step" in found.failed["next"]


def _of_next(observation, action, next_observation, info):
    return float(next_observation[0])
