"""Only finite numbers pass the gate between env, learner and record; no cell counts as done after another one."""

import re
from itertools import product

import gymnasium
import numpy as np
import pytest

from harness.env import decisions
from harness.env.arm_observation import ArmObservation
from harness.env.decisions import Shaping, Starts
from harness.env.episodes import Episodes
from harness.env.vector_env import ReachVectorEnv
from harness.executor import CellOptions
from harness.experiment import run_cell as cells
from harness.experiment.environments import world as worlds
from harness.experiment.environments.world import EnvironmentBatch
from harness.experiment.plan import check_experiment, expand
from harness.policy import Deterministic, Uniform
from harness.recorder import gate

STEPS, LATE, LAST = 200, 150, 200
OFF = "net_arch=8,batch_size=8,learning_starts=40"
LINE, CHOICES, GOALS, ARM = (
    {"task": "toy", "baseline": "near"},
    {"task": "toy:discrete=true", "baseline": "near"},
    {"task": "goal_toy", "baseline": "there"},
    {"task": "fd100-reach:horizon=300", "sim": "kinematic"},
)
ALGORITHMS = {
    "random": LINE,
    "spg:net_arch=8,decisions=20,num_envs=1": LINE,
    f"sac-fast:{OFF}": LINE,
    f"sb3-sac:{OFF}": LINE,
    f"td3:{OFF}": LINE,
    "ppo:net_arch=8,batch_size=8,rollout=32,num_envs=1": LINE,
    f"dqn:{OFF}": CHOICES,
    f"ddqn:{OFF}": CHOICES,
    f"her:{OFF}": GOALS,
    "ik": ARM,
}
NUMBERS = {"nan": "NaN", "inf": "infinite", "-inf": "infinite"}
NAMES = {
    "start": "(target|observation( at| achieved_goal)?) 0",
    "observation": r"observation( at| achieved_goal)? 0",
    "action": "action 0",
    "pay": "pay",
    "info": "(info |begin_)?(distance|success)( 0)?",
}


class Spoils(gymnasium.Wrapper):
    """Gives such a number in one field of one step, or in the observation of each start."""

    def __init__(self, env, field, number, late):
        super().__init__(env)
        self.field, self.number, self.late, self.steps = field, number, late, 0

    def reset(self, **asked):
        """The start, or what is left of it."""
        seen, info = self.env.reset(**asked)
        return self._spoilt(seen) if self.field == "start" else seen, info

    def step(self, action):
        """The step, or what is left of it."""
        seen, paid, terminated, truncated, info = self.env.step(action)
        self.steps += 1
        if self.steps == self.late:
            paid = self.number if self.field == "pay" else paid
            if self.field == "info":
                info = dict.fromkeys(info, self.number)
            if self.field == "observation":
                seen = self._spoilt(seen)
        return seen, paid, terminated, truncated, info

    def _spoilt(self, seen):
        return {key: np.full_like(it, self.number) if np.ndim(it) else it for key, it in seen.items()}


def _spoils(monkeypatch, owner, name, number, late):
    """Let a method spoil the first number of what it is given (`step`), or returns, at one of its calls."""
    true, calls = getattr(owner, name), []

    def spoilt(self, *given):
        calls.append(1)
        if name == "step" and len(calls) == late:
            given = (np.array(given[0], float),)
            given[0][(0,) * given[0].ndim] = float(number)
        found = true(self, *given)
        if name != "step" and len(calls) == late:
            first = found[0] if isinstance(found, tuple) else found
            first[(0,) * first.ndim] = float(number)
        return found

    monkeypatch.setattr(owner, name, spoilt)


@pytest.fixture
def spoil(monkeypatch):
    """Lets the training meet such a number in one of its steps."""

    def later(keys, field, number, late):
        if "sim" in keys:
            owner, name = {
                "start": (Starts, "_first_target"),
                "observation": (ArmObservation, "observe"),
                "pay": (Shaping, "pay"),
                "info": (Episodes, "_errors"),
            }.get(field, (ReachVectorEnv, "step"))
            _spoils(monkeypatch, owner, name, number, late + (field in ("observation", "info")))  # a start is the first
        elif field == "action":
            _spoils(monkeypatch, EnvironmentBatch, "step", number, late)
        else:
            made = worlds.envs_together

            def spoilt(*asked):
                return [Spoils(it, field, float(number), late) for it in made(*asked)]

            monkeypatch.setattr(worlds, "envs_together", spoilt)

    return later


@pytest.fixture
def run(registry, given, tmp_path):
    """The manifest of a cell."""

    def done(algo, keys, steps=STEPS):
        asked = {"algo": algo, "reward": [], "seeds": 1, "steps": steps, "evaluation_episodes": 1, **keys}
        cell = expand(check_experiment(asked), registry).cells[0]
        return cells.run_cell(cell, tmp_path / "cell", lambda word: None, CellOptions(plugins=given))

    return done


def _told(field, number, late, keys):
    late = 0 if field == "start" else r"\d+" if "sim" in keys else late
    where = rf"{late} of episode \d+, env 0" if "sim" in keys else late
    return rf"SimulationDiverged: {NAMES[field]} was {NUMBERS[number]} at step {where}"


def _can_be(field, keys, late):
    return not ((field == "action" and keys is CHOICES) or (field == "start" and late > 1))


def _is_quick(algo, number, late):
    return algo in ("random", "ik") and (late == LATE) == (number == "nan")


CASES = [
    pytest.param(
        algo, keys, field, number, late, id=f"{algo.partition(':')[0]}-{field}-{number}-{late}",
        marks=[pytest.mark.slow] * (not _is_quick(algo, number, late)),
    )
    for (algo, keys), field, number, late in product(ALGORITHMS.items(), NAMES, NUMBERS, (1, LATE, LAST))
    if _can_be(field, keys, late)
]  # fmt: skip


@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize(("algo", "keys", "field", "number", "late"), CASES)
def test_a_number_that_is_not_finite_fails_the_cell(run, spoil, algo, keys, field, number, late):
    """In the step that brings it, by its name, with every algorithm and in every world."""
    spoil(keys, field, number, late)
    assert re.fullmatch(_told(field, number, late, keys), run(algo, keys).reason)


def test_the_env_is_named_where_there_are_several(run, spoil):
    """Each env counts its own steps."""
    spoil(LINE, "observation", "nan", 7)
    manifest = run("random:num_envs=3", LINE, steps=60)
    assert manifest.reason == "SimulationDiverged: observation at 0 was NaN at step 7 of env 0"


@pytest.mark.parametrize(("keys", "place"), [(LINE, "3 of an evaluation"), (ARM, "3 of episode 0, env 0")])
def test_an_evaluation_has_the_same_gate(run, monkeypatch, keys, place):
    """A policy that chooses what is no number."""
    actions, true = [], Uniform.act

    def act(self, observation, rng=None):
        actions.append(true(self, observation, rng))
        return actions[-1] if len(actions) < 3 else np.full_like(actions[-1], np.nan)

    size = 6 if keys is ARM else 1
    monkeypatch.setattr(Uniform, "act", act)
    monkeypatch.setattr(cells._Run, "_train", lambda *_: Uniform((-1.0,) * size, (1.0,) * size))
    assert run("random", keys, steps=8).reason == f"SimulationDiverged: action 0 was NaN at step {place}"


@pytest.mark.parametrize("keys", [LINE, ARM], ids=["environment", "arm"])
def test_a_policy_that_cannot_be_read_back_is_not_done(run, monkeypatch, keys, tmp_path):
    """Whatever its learner says, and before any of it is evaluated."""
    weights = {"mean.weight": np.full((1, 2), np.nan, np.float32), "mean.bias": np.zeros(1, np.float32)}
    monkeypatch.setattr(cells._Run, "_train", lambda *_: Deterministic(weights, "relu", (-1.0,), (1.0,)))
    manifest = run("random", keys, steps=8)
    told = f"{tmp_path / 'cell' / 'policy'} holds no readable policy: mean.weight has numbers that are not finite"
    assert told in manifest.reason
    assert "evaluation" not in " ".join(manifest.files)


LEARNERS = [
    pytest.param(f"{algo},learning_rate=1e30", keys, id=algo.partition(":")[0])
    for algo, keys in ALGORITHMS.items()
    if ":" in algo
]
LOST = "SimulationDiverged: action 0 was NaN at step|SchemaError: .* holds no readable policy: .* that are not finite"


@pytest.mark.filterwarnings("ignore::RuntimeWarning", "ignore::UserWarning")
@pytest.mark.parametrize(("algo", "keys"), LEARNERS)
def test_a_learner_that_loses_its_numbers_fails_the_cell(run, algo, keys):
    """With no number of the env out of order: the learner's action is named, or the weights that it left."""
    manifest = run(algo, keys)
    assert (manifest.status, bool(re.match(LOST, manifest.reason))) == ("failed", True), manifest.reason


@pytest.mark.parametrize("field", NAMES)
@pytest.mark.parametrize(("module", "keys"), [(gate, LINE), (decisions, ARM)])
def test_each_door_needs_its_gate(run, spoil, monkeypatch, module, keys, field):
    """Taken out of one, what it had to find is not told."""
    monkeypatch.setattr(module, "require_finite", lambda *_: None)
    number, late = ("inf", 1) if field == "start" else ("nan", 7)
    spoil(keys, field, number, late)
    assert not re.fullmatch(_told(field, number, late, keys), run("random", keys, steps=20).reason)
