"""From a world to what a cheat would do there."""

import json

import gymnasium
import numpy as np
import pytest
from gymnasium.spaces import Box, Discrete

from harness.experiment.screening import CANNOT_TELL, FAILING, NOTHING
from harness_plugins.audit import find_cheats
from harness_plugins.audit.search.find import Search
from tests.refusals import refused


class Dock(gymnasium.Env):
    """A point that docks at 1 on a line, which ends an episode."""

    observation_space = Box(-np.inf, np.inf, (1,), np.float64)
    action_space = Box(-1.0, 1.0, (1,), np.float64)

    def reset(self, **options):
        """Begin between -0.1 and 0.1."""
        super().reset(**options)
        self.at, self.steps = self.np_random.uniform(-0.1, 0.1), 0
        return np.array([self.at]), {}

    def step(self, action):
        """Move by a tenth of the action."""
        self.at, self.steps = self.at + 0.1 * float(action[0]), self.steps + 1
        docked = self.at >= 1.0
        return np.array([self.at]), 0.0, docked, self.steps >= 30, {"docked": docked}


def near(observation, action, next_observation, info):
    """Being near pays in every step, and docking ends that."""
    return max(float(next_observation[0]), 0.0)


def nearer(observation, action, next_observation, info):
    """Coming nearer pays, going back costs, and docking pays once."""
    return float(next_observation[0] - observation[0]) + 1.0 * info["docked"]


FEW = {"budget": 6_000, "starts": 2}


@pytest.fixture(scope="module")
def found():
    """Both rewards in the dock."""
    return find_cheats(Dock, {"near": near, "nearer": nearer}, success="docked", **FEW)


def test_a_hack_is_found_and_an_honest_reward_is_not_accused(found):
    """Of two rewards that sound alike."""
    assert [finding.word for finding in found.cheats] == [FAILING, NOTHING]


def test_an_alarm_says_whether_it_is_a_knifes_edge(found):
    """With the curve of noise of the three that are shown; where there is none nothing is said."""
    alarm, honest = found.cheats
    assert alarm.strength in alarm.lines[2]
    assert (alarm.strength != "", honest.strength) == (True, "")
    assert {of.noise for of in alarm.noise} == {0.0, 0.01, 0.05}


def test_what_is_shown_is_what_was_found(found):
    """Played again, it pays the same, step by step."""
    for finding in found.cheats:
        for role, behaviour in finding.three.items():
            assert finding.shown[role].paid.sum() == pytest.approx(behaviour.paid, abs=1e-12)


def test_the_same_call_finds_the_same(found):
    """Bit for bit."""
    again = find_cheats(Dock, {"near": near, "nearer": nearer}, success="docked", **FEW)
    assert json.dumps(again.to_json()) == json.dumps(found.to_json())


def test_it_prints_the_answer_with_its_word_first(found):
    """Below the table of the three."""
    text = str(found)
    assert "\nPAYS FOR FAILING, " in text
    assert "\nNOTHING FOUND. Failing earns " in text
    assert "That proves nothing: " in text


def test_json_holds_what_was_found(found):
    """Finite numbers alone."""
    (alarm, _) = found.to_json()["cheats"]
    assert (alarm["answer"], alarm["success_told_by"]) == (FAILING, "docked")
    assert alarm["shown"]["failure"]["paid"] > alarm["shown"]["fastest"]["paid"]
    json.dumps(alarm, allow_nan=False)


def test_without_a_measure_of_success_it_asks():
    """It names the measures that there are."""
    place = {"place": lambda observation, action, next_observation, info: float(next_observation[0])}
    (finding,) = find_cheats(Dock, {"near": near}, behaviour=place, **FEW).cheats
    assert (finding.word, finding.success) == (CANNOT_TELL, "")
    assert finding.lines[0].startswith("Nothing measures success. What is paid most earns ")
    assert "with one of place" in finding.lines[1]


def test_a_policy_that_does_the_task_is_begun_from():
    """By its name. Its bare actions would not come back from what disturbs them, so it acts again."""
    asked = []

    def go(seen):
        asked.append(seen)
        return np.ones(1)

    found = find_cheats(Dock, {"nearer": nearer}, policies={"go": go}, success="docked", budget=600, starts=1)
    assert found.cheats[0].three["fastest"].made_by == "policy go"
    assert len(asked) > 2 * 32 * 9


def test_starts_are_those_of_no_evaluation():
    """Drawn by the seed, none twice."""
    starts = Search(1, 50, seed=3).draw_starts()
    assert starts == Search(1, 50, seed=3).draw_starts() != Search(1, 50, seed=4).draw_starts()
    assert len({*starts}) == 50
    assert all(100_000 <= start < 1_000_000 for start in starts)


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        ({"gamma": 1.5}, "gamma=1.5"),
        ({"budget": 0}, "budget=0"),
        ({"starts": 0}, "starts=0"),
        ({"seed": -1}, "seed=-1"),
        ({"rewards": {}}, "name at least one"),
        ({"policies": {"still": 3}}, "policies: 'still' is 3"),
    ],
)
def test_what_cannot_be_is_refused(wrong, text):
    """In one sentence."""
    with refused(text):
        find_cheats(Dock, **{"rewards": {"near": near}, **FEW, **wrong})


class Corridor(gymnasium.Env):
    """Ten cells; the last one is success, and ends an episode of at most 20 steps."""

    observation_space = Discrete(10)
    action_space = Discrete(2)

    def reset(self, **options):
        """Begin in cell 2."""
        super().reset(**options)
        self.at, self.steps = 2, 0
        return self.at, {}

    def step(self, action):
        """Left or right."""
        self.at, self.steps = max(0, self.at + 2 * int(action) - 1), self.steps + 1
        return self.at, 0.0, self.at == 9, self.steps == 20, {"done": self.at == 9}


class Streak:
    """Pays 10 for the last cell, and 3 for every step from the eighth to the left in a row: nobody observes those."""

    def __init__(self):
        """Nothing is counted yet."""
        self.reset()

    def reset(self):
        """Count from 0."""
        self.count = 0

    def __call__(self, observation, action, next_observation, info):
        """Count, and pay."""
        self.count = 0 if action else self.count + 1
        return 10.0 * info["done"] + 3.0 * (self.count > 7)


def test_what_a_reward_remembers_is_no_table():
    """Random steps agree with a table that knows nothing of it; sequences are paid more, so it is not believed."""
    (finding,) = find_cheats(Corridor, {"streak": Streak()}, success="done", budget=20_000, starts=1).cheats
    assert (finding.word, "table" in finding.searched.how) == (FAILING, False)
    assert finding.three["failure"].paid == 13 * 3.0
    (finding,) = find_cheats(Corridor, {"own": "own"}, success="done", budget=20_000, starts=1).cheats
    assert (finding.searched.how, finding.lines[-1]) == (
        ("table",), "All states and actions were counted: nothing pays more."
    )  # fmt: skip


class Late(Corridor):
    """Tells success as NaN until an episode ends."""

    def step(self, action):
        """As before."""
        seen, paid, ended, cut, _ = super().step(action)
        return seen, paid, ended, cut, {"is_success": float(ended) if ended or cut else np.nan}


def test_success_may_be_nan_until_an_episode_ends():
    """That is not told yet, and no failure of the environment."""
    (finding,) = find_cheats(Late, {"own": "own"}, budget=5_000, starts=1).cheats
    assert (finding.success, finding.three["fastest"].time) == ("is_success", 7)
