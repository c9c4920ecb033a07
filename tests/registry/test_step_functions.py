"""Functions in plugin files: rewards and measures for the steps of any environment."""

import re
from pathlib import Path

import pytest

from harness import load_registry
from harness.errors import UsageError
from harness.registry import read_given, split_measures

ONE = """
import math
from math import sqrt


def pays(observation, action, next_observation, info):
    return _half(next_observation)


def _half(value):
    return value / 2
"""
MEMORY = """
class effort:
    def reset(self):
        self.sum = 0.0

    def __call__(self, observation, action, next_observation, info):
        self.sum += abs(action)
        return self.sum
"""


@pytest.fixture
def lay(tmp_path):
    """Write a file; gives its path."""

    def write(name, source):
        (tmp_path / name).write_text(source, encoding="utf-8")
        return tmp_path / name

    return write


def _registry(*paths, measures=()):
    return load_registry([], read_given(paths, measures))


def test_one_function_has_the_name_of_its_file(lay):
    """Imported functions and those whose names begin with _ do not count."""
    registry = _registry(lay("calm.py", ONE))
    (calm,) = registry.functions
    assert (calm.name, calm.noun, calm.make()(None, None, 3.0, {})) == ("calm", "reward", 1.5)
    assert registry.plugins[0].registered == ("reward calm of environments",)


def test_several_functions_have_their_own_names(lay):
    """In the order of the file."""
    registry = _registry(lay("both.py", ONE + MEMORY))
    assert [it.name for it in registry.functions] == ["pays", "effort"]


def test_class_with_a_memory_makes_an_object_for_each_env(lay):
    """Two envs share nothing."""
    (effort,) = _registry(lay("effort.py", MEMORY)).functions
    one, other = effort.make(), effort.make()
    one.reset(), other.reset()
    one(0, 2.0, 0, {})
    assert (one(0, 2.0, 0, {}), other(0, 2.0, 0, {})) == (4.0, 2.0)


@pytest.mark.parametrize("name", ["behaviour.py", "behavior.py"])
def test_functions_of_a_file_called_behaviour_are_measures(lay, name):
    """Each under its own name, one alone too; the file says of which less is better."""
    (effort,) = _registry(lay(name, MEMORY + "lower_is_better = ['effort']")).functions
    assert (effort.name, effort.noun, effort.better) == ("effort", "measure", "lower")


def test_any_file_may_be_one_of_measures(lay):
    """Where the user says so, even if it is named as a plugin too."""
    path = lay("mine.py", ONE)
    (pays,) = _registry(path, measures=(path,)).functions
    assert (pays.name, pays.noun) == ("pays", "measure")
    assert read_given([], [path])[0].need["measures"] is True


def test_a_class_is_called_in_lower_case(lay):
    """As classes are named."""
    registry = _registry(lay("both.py", ONE + MEMORY.replace("class effort", "class Effort")))
    assert [it.name for it in registry.functions] == ["pays", "effort"]


@pytest.mark.parametrize("pays", ["-step.observation[0]", "-step.before.info['x']"])
def test_reward_of_an_environment_may_have_the_name_of_an_arms(lay, pays):
    """The arm's own stays."""
    registry = load_registry(given=read_given([lay("dense.py", f"def dense(step):\n    return {pays}")]))
    assert [*registry.functions_of("reward")] == ["dense"]
    assert registry.get("rewards", "dense").target == "harness_plugins.rewards.dense:Dense"


def test_reward_of_an_arm_may_not(lay):
    """Nobody could tell which of them paid."""
    with pytest.raises(UsageError, match="the name of reward 'dense' is taken by package fd100-harness"):
        load_registry(given=read_given([lay("dense.py", "def dense(step):\n    return -step.distance")]))


def test_a_measure_may_be_called_as_a_reward(lay):
    """They are different things."""
    registry = _registry(lay("pays.py", ONE), lay("behaviour.py", ONE))
    assert list(registry.functions_of("reward")) == list(registry.functions_of("measure")) == ["pays"]


BAD = {
    "other arguments": ("def pay(state):\n    return 1", "it has pay(state), and a reward or a measure takes (step)"),
    "a capital": (ONE.replace("def pays", "def Pays") + MEMORY, "the name 'Pays' must be lower-case letters"),
    "a class beside a function": (MEMORY + MEMORY.replace("effort", "Effort"), "the name 'Effort' must be lower-case"),
    "lower of nothing": ("lower_is_better = ['x']\n" + ONE, "lower_is_better names 'x', which is none of pays"),
    "lower of a reward": (
        "lower_is_better = ['pays']\n" + ONE,
        "lower_is_better and higher_is_better go with measures",
    ),
    "a class that is half a plugin": (ONE + "class Other:\n    def train(self): ...", "Other has no "),
    "a class that is nothing": ("class Other: ...", "Other has no "),
}


@pytest.mark.parametrize(("source", "told"), BAD.values(), ids=BAD)
def test_bad_file_is_told_in_one_line(lay, source, told):
    """With the file and what to do."""
    with pytest.raises(UsageError) as error:
        _registry(lay("bad.py", source))
    assert told in str(error.value)
    assert "bad.py" in str(error.value)


def test_other_classes_of_a_file_are_its_own(lay):
    """Settings, as a dataclass."""
    source = "from dataclasses import dataclass\n@dataclass\nclass Settings:\n    weight: float = 2.0\n" + ONE
    assert [it.name for it in _registry(lay("calm.py", source)).functions] == ["calm"]


CALLED = "class Weighed:\n    def __call__(self, observation, action, next_observation, info):\n        return 2.0\n"
PARTIAL = (
    "from functools import partial\ndef _pay(s, a, n, i, weight):\n    return weight\nit = partial(_pay, weight=2.0)"
)


@pytest.mark.parametrize("source", [CALLED, CALLED + "reward = Weighed()", PARTIAL])
def test_what_can_be_called_for_a_step_is_a_reward(lay, source):
    """A class without a memory, an object of a class, a partial."""
    (found,) = _registry(lay("calm.py", source)).functions
    assert found.name == "calm"
    assert found.make()(None, None, None, {}) == 2.0


def test_two_functions_of_one_name_are_refused(lay, tmp_path):
    """With both files."""
    with pytest.raises(UsageError, match=r"other\.py': the reward 'effort' stands in '.*both\.py' too"):
        _registry(lay("both.py", ONE + MEMORY), lay("other.py", MEMORY + ONE.replace("pays", "more")))


def test_pattern_finds_files(lay, tmp_path):
    """In the order of their names; those that begin with _ are for the others."""
    for name in ("b.py", "a.py", "_parts.py", "notes.txt"):
        lay(name, ONE)
    assert [it.name for it in read_given([f"{tmp_path}/*"])] == ["a.py", "b.py"]


def test_file_that_a_pattern_finds_may_be_broken(lay, tmp_path):
    """The others go on, and it is named; named by itself it is an error."""
    broken = lay("broken.py", "def (")
    lay("calm.py", ONE)
    registry = _registry(tmp_path / "*.py")
    assert [it.name for it in registry.functions] == ["calm"]
    (line,) = registry.broken_files()
    assert line.startswith("Left out: Plugin file")
    assert "SyntaxError" in line
    assert [need["path"] for need in registry.needs(in_environment=True)] == [str(tmp_path / "calm.py")]
    with pytest.raises(UsageError, match="SyntaxError"):
        _registry(broken)


def test_a_report_of_an_arm_needs_the_file_of_a_function(tmp_path):
    """What it pays is no column of other trainings' traces, as it is of recordings."""
    (tmp_path / "calm.py").write_text("def calm(step):\n    return -step.distance\n")
    registry = load_registry(given=read_given([tmp_path / "calm.py"]))
    assert [need.get("functions") for need in registry.needs(in_environment=False)] == [None]
    assert [need.get("functions") for need in registry.needs(in_environment=True)] == [True]


def test_pattern_that_finds_nothing_is_refused(tmp_path):
    """It is mistyped."""
    with pytest.raises(UsageError, match=r"No Python file matches '.*\*\.py'"):
        read_given([tmp_path / "*.py"])


def test_reward_of_an_arm_is_told_from_one_of_environments(lay):
    """A function of an observation cannot pay an arm."""
    with pytest.raises(UsageError, match=r"No reward 'calm'.*In calm\.py, pays\(observ.*\) pays in environments"):
        _registry(lay("calm.py", ONE)).get("rewards", "calm")


def test_measures_are_names_and_files():
    """As a command line or a program gives them."""
    assert split_measures("height, my/measures.py,effort") == (["height", "effort"], ["my/measures.py"])
    assert split_measures([Path("a.py"), "b"]) == (["b"], ["a.py"])


HELPERS = "def calm(step):\n    return clip(step.observation[0], 1)\n\n\ndef clip(x, most=1):\n    return x\n"


def test_helper_function_is_no_reward(lay):
    """The file's own: told where somebody names it."""
    registry = _registry(lay("rewards.py", HELPERS))
    assert [it.name for it in registry.functions] == ["rewards"]
    assert registry.plugins[0].own == ("clip(x, most=1)",)
    with pytest.raises(
        UsageError, match=r"In rewards\.py, clip\(x, most=1\) is no reward: a reward or a measure takes"
    ):
        registry.get("rewards", "clip")


STEPS = (
    "class Weighed:\n    def __call__(self, step):\n        return 2.0\n",
    "from functools import partial\ndef _pay(step, weight):\n    return weight\nit = partial(_pay, weight=2.0)",
    "def pays(step, weight=2.0):\n    return weight\n",
    "class effort:\n    def reset(self): ...\n    def __call__(self, step):\n        return 2.0\n",
)


@pytest.mark.parametrize("source", STEPS)
def test_what_takes_a_step_is_a_reward(lay, source):
    """A class, with a memory or without, a partial, a function with a default."""
    (found,) = _registry(lay("calm.py", source)).functions
    assert (found.name, found.make()(None)) == ("calm", 2.0)


@pytest.mark.parametrize(
    ("source", "asked", "told"),
    [
        ("def calm(observation, action, next_observation, info):\n    return 0.0\n", "calm",
         "In calm.py, calm(observation, action, next_observation, info) pays in environments"),
        ("class Calm:\n    def __call__(self, step):\n        return 0.0\n", "calm",
         "In calm.py, the class Calm pays in environments"),
        ("def compute_reward(step):\n    return -step.distance\n", "compute_reward",
         "In calm.py, compute_reward is called 'calm', as its file"),
    ],
)  # fmt: skip
def test_a_function_that_is_no_reward_of_the_name_is_told(tmp_path, source, asked, told):
    """Who asks an arm for what pays environments alone, or for a function by its name in the file."""
    (tmp_path / "calm.py").write_text(source)
    registry = load_registry(given=read_given([tmp_path / "calm.py"]))
    with pytest.raises(UsageError, match=re.escape(told)):
        registry.get("rewards", asked)
