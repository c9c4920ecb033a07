"""What a search begins from."""

import re
from contextlib import closing

import numpy as np
import pytest
from gymnasium.spaces import Box, Tuple
from numpy.testing import assert_array_equal

from harness import RecordRewards
from harness.env.arm_observation import kinematics_policy
from harness.env.vector_env import World as Arm
from harness.recorder.env_facts import Columns
from harness.reward.terms import Unpaid
from harness.task import ReachTask
from harness_plugins.audit.audit import finding_parts
from harness_plugins.audit.search.arm_world import ArmWorld
from harness_plugins.audit.search.beginnings import of_folder, policy_named
from harness_plugins.audit.search.environment_world import of_env
from harness_plugins.audit.search.find import Search, find_in
from harness_plugins.kit import IdealSimulator
from tests.plugins.audit.search.test_arm_world import ROBOT
from tests.plugins.audit.search.test_environment_world import LENGTH, Dock
from tests.refusals import refused

STARTS = np.array([3, 5])


def arm(**options):
    """A world of an arm that nothing is paid."""
    return ArmWorld(Arm(IdealSimulator(), ROBOT, ReachTask(**options), Unpaid()), "reach", "none", 0.99)


def docks():
    """A world of ships."""
    return of_env(Dock, "own", Columns({"own": "own"}, {}, ()), 0.9)


def kinds(begun):
    """What they come from, each once."""
    return list(dict.fromkeys(it.made_by for it in begun))


def test_scripts_are_made_for_each_start():
    """Five movements; the one that finishes does so from where it was made for, and what kinematics say does too."""
    world = arm()
    begun = world.scripts(STARTS)
    names = [f"script {it}" for it in ("finish", "hover", "creep", "oscillate", "hold")]
    assert kinds(begun) == ["inverse kinematics", *names]
    (finish,) = [it for it in begun if it.made_by == "script finish"]
    assert world.play(STARTS, np.stack(finish.actions)).success.all()
    assert world.act(STARTS, begun[0].act)[0].success.all()


@pytest.mark.parametrize("action", ["movel", "discrete"])
def test_other_actions_have_no_scripts(action):
    """Scripts move joints."""
    assert arm(action=action).scripts(STARTS) == []


def test_a_function_in_a_file_is_a_policy(tmp_path):
    """By its name."""
    file = tmp_path / "cheats.py"
    file.write_text("def stand(observation):\n    return [0.0]\n")
    world = docks()
    begun = policy_named(world, f"{file}:stand")
    outcomes, taken = world.act(np.array([0]), begun.act)
    assert (begun.made_by, outcomes.steps[0], taken[0].any()) == ("policy stand", LENGTH, False)
    with refused("has no function 'walk'"):
        policy_named(world, f"{file}:walk")


@pytest.mark.parametrize(
    ("body", "text"),
    [
        ("raise KeyError('knee')", "cheats.py:walk fails: KeyError: 'knee'"),
        ("return [0.0, 1.0]", r"cheats.py:walk gives \[0.0, 1.0\], which is no action of Dock"),
        ("return 'left'", "cheats.py:walk gives 'left', which is no action of Dock"),
    ],
)
def test_what_a_policy_does_wrong_is_its_own_fault(tmp_path, body, text):
    """And not the environment's."""
    (tmp_path / "cheats.py").write_text(f"def walk(observation):\n    {body}\n")
    world = docks()
    with refused(text):
        world.act(np.array([0]), policy_named(world, f"{tmp_path / 'cheats.py'}:walk").act)


def test_a_saved_policy_acts(tmp_path):
    """In the world that it was trained in, and not in another one."""
    world = arm()
    kinematics_policy(world.arm.task, ROBOT).save(tmp_path / "mine")
    begun = policy_named(world, str(tmp_path / "mine"))
    assert begun.made_by == "policy mine"
    assert world.act(STARTS, begun.act)[0].success.all()
    with refused("does not act in Dock"):
        policy_named(docks(), str(tmp_path / "mine"))


def test_nothing_is_no_policy():
    """It says what to write."""
    with refused(r"FILE\.py:NAME"):
        policy_named(docks(), "nowhere")


def test_recorded_trainings_tell_what_was_done(tmp_path):
    """The best-paid episodes, and the last ones, as they were."""
    env = RecordRewards(Dock(), tmp_path / "steps", trained_with="own", rewards={"own": "own"})
    env.action_space.seed(0)
    done, paid = [], []
    for episode in range(40):
        env.reset(seed=episode)
        done.append(np.array([env.action_space.sample() for _ in range(LENGTH)]))
        paid.append(sum(float(env.step(action)[1]) for action in done[-1]))
    env.close()
    begun, left_out = of_folder(docks(), tmp_path)
    best, latest = np.argsort(-np.array(paid))[:8], np.arange(39, 31, -1)
    expected = list(dict.fromkeys([*best.tolist(), *latest.tolist()]))
    assert (kinds(begun), left_out) == (["recorded training"], [])
    assert_array_equal([it.actions[0] for it in begun], [done[number] for number in expected])


def test_an_empty_folder_is_refused(tmp_path):
    """With what it should hold."""
    with refused("holds no policy and no recorded actions"):
        of_folder(docks(), tmp_path)


SIDE = Box(-1.0, 1.0, (2,), np.float64)
OTHERS = {
    r"its actions are none of Box\(-1.0, 1.0, \(1,\), float64\)": (lambda: Dock(SIDE), 0),
    "its env was not reset with a seed": (Dock, None),
    "it does not hold its actions": (lambda: Dock(Tuple([SIDE])), 0),
}
"""Why a recorded training begins no search: the env that it was recorded in, and the seed of its reset."""


def record(folder, make, seed, count=2):
    """Trainings of a few steps each."""
    for number in range(count):
        with closing(RecordRewards(make(), folder / f"{number}", trained_with="own", rewards={"own": "own"})) as env:
            env.action_space.seed(0)
            env.reset(seed=seed)
            for _ in range(LENGTH):
                env.step(env.action_space.sample())


@pytest.mark.parametrize("why", OTHERS)
def test_recordings_that_begin_no_search_are_told(why, tmp_path):
    """In one line, beside those that do, in a terminal and as JSON; and where there are no others, in the refusal."""
    record(tmp_path / "others", *OTHERS[why])
    with refused(rf"no recorded actions that fit Dock; there is 2 \({why}\)\. Name"):
        of_folder(docks(), tmp_path)
    record(tmp_path / "same", Dock, 0)
    asked = Search(2_000, 2, folders=(tmp_path,))
    with closing(docks()) as world:
        found = find_in(world, asked)
    (told,) = [line for line in found.to_json()["lines"] if "leaves out" in line]
    assert re.fullmatch(rf"Of the policies and recorded trainings in '.*' the search leaves out 2 \({why}\)\.", told)
    assert told in [str(part) for part in finding_parts(found)]


def test_recordings_of_other_actions_are_left_out(tmp_path):
    """They do not fit."""
    record(tmp_path, Dock, 0, count=1)
    with refused("holds no policy"):
        of_folder(arm(), tmp_path)
