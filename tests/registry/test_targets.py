"""Targets compared with what their kind asks for: each way to be wrong is told, and what is right is not."""

from dataclasses import dataclass
from typing import ClassVar

import pytest

from harness import load_registry
from harness.algorithm import Algorithm
from harness.errors import PluginError
from harness.executor import Executor, Screen, Tracker
from harness.hookspecs import KINDS
from harness.log import LogFormat, Measure
from harness.registry import Registry, Spec
from harness.registry.members import MEMBERS, missing_members, require_members
from harness.registry.targets import examined, why_absent, why_unfit
from harness.results import Section
from harness.reward import Reward
from harness.robot import DescriptionFormat
from harness.simulator import Simulator
from harness.task import Task

PROTOCOLS = {
    "simulators": Simulator, "algorithms": Algorithm, "rewards": Reward, "metrics": Measure, "tasks": Task,
    "executors": Executor, "trackers": Tracker, "logs": LogFormat, "sections": Section,
    "descriptions": DescriptionFormat, "screens": Screen,
}  # fmt: skip


def _spec(target, kind="rewards", requires=()):
    return Spec(kind, "mine", target, "", requires, None, "one", "cem-algo", "0.1")


def _members_of(protocol):
    own = {name: it for name, it in vars(protocol).items() if not name.startswith("_") or name == "__call__"}
    return {
        name: None if isinstance(it, property) else it.__code__.co_argcount - 1
        for name, it in own.items()
        if isinstance(it, property) or hasattr(it, "__code__")
    }


def test_members_are_those_of_the_interface(subtests):
    """The table says what the protocol says: names, and arguments beside self."""
    for kind, protocol in PROTOCOLS.items():
        with subtests.test(kind=kind):
            assert dict(MEMBERS[kind]) == _members_of(protocol)


def test_built_in_targets_are_found_and_fit():
    """Every one that can be imported here; nothing is told of the others."""
    registry = load_registry()
    ours = [spec for spec in registry.all_specs() if spec.is_built_in]
    assert [why_absent(spec) for spec in ours] == [""] * len(ours)
    light = [spec for spec in ours if spec.kind in {"rewards", "metrics", "tasks", "robots"}]
    assert {spec.kind for spec in ours} <= set(KINDS)
    assert [why_unfit(spec) for spec in light] == [""] * len(light)


ABSENT = {
    "no module": ("no_such_module_here:Mine", "there is no module 'no_such_module_here'"),
    "no package": ("no_such_package_here.mine:Mine", "cannot be found: ModuleNotFoundError"),
    "no name, imported": ("json.decoder:JSONDecodr", "has no 'JSONDecodr'. Did you mean 'JSONDecoder'?"),
    "no name, not imported": ("this_is_{}:Mnie", "has no 'Mnie'. Did you mean 'Mine'?"),
    "does not parse": ("unparsed_{}:Mine", "cannot be found: SyntaxError"),
}


@pytest.fixture
def lay(tmp_path, monkeypatch):
    """Lay a module where it can be imported; gives its name."""
    monkeypatch.syspath_prepend(tmp_path)

    def write(name, source):
        module = f"{name}_{tmp_path.name}".replace("-", "_")
        (tmp_path / f"{module}.py").write_text(source)
        return module

    return write


@pytest.mark.parametrize(("target", "told"), ABSENT.values(), ids=ABSENT)
def test_absent_target_is_told(lay, target, told):
    """With kind, name, distribution and version, and what may be meant; nothing is imported for it."""
    lay("this_is", "raise SystemExit\nclass Mine: ...\n")
    module = lay("unparsed", "class Mine(")
    found = why_absent(_spec(target.format(module.removeprefix("unparsed_"))))
    assert found.startswith("Reward 'mine' of package cem-algo 0.1: ")
    assert told in found


@pytest.mark.parametrize(
    "source",
    ["class Mine: ...", "from json import JSONDecoder as Mine", "Mine = 3", "if True:\n    Mine = 3", "def Mine(): ...",
     "from json import *", "def __getattr__(name): ..."],
)  # fmt: skip
def test_target_that_may_be_there_is_not_absent(lay, source):
    """However a module binds the name; one that cannot be read off is not complained of."""
    assert why_absent(_spec(lay("there", f"{source}\n") + ":Mine")) == ""


def test_plugin_with_an_absent_target_is_broken():
    """Its neighbours stay as they are."""
    registry = Registry()
    registry.plugins += [_plugin("one", "cem-algo"), _plugin("two", "other")]
    registry.specs["rewards", "mine"] = [_spec("no_such_module_here:Mine")]
    assert [plugin.status for plugin in examined(registry)] == ["broken", "ok"]


def _plugin(name, distribution):
    from harness.registry.choice import Plugin

    return Plugin(name, distribution, "0.1", "m", "ok")


@dataclass(frozen=True)
class Whole:
    """A reward."""

    def initial_carry(self, begin_distance):
        """Nothing."""
        return ()

    def __call__(self, carry, sample):
        """Some."""
        return carry, sample.distance


@dataclass(frozen=True)
class Silent:
    """Lacks the call."""

    def initial_carry(self, begin_distance):
        """Nothing."""
        return ()


@dataclass(frozen=True)
class Eager(Whole):
    """Is called with too few."""

    def __call__(self, sample):
        """Some."""
        return sample.distance


class Plain:
    """No dataclass."""


@dataclass(frozen=True)
class Learner:
    """An algorithm, of which one member is a field without a default."""

    num_envs: int
    action_spaces: ClassVar = frozenset({"continuous"})

    def train(self, env, steps, seed, progress):
        """Learn nothing."""


@dataclass(frozen=True)
class Narrow(Learner):
    """Is asked for fewer things."""

    def train(self, env, steps):
        """Learn nothing."""


UNFIT = {
    "lacks a member": ("Silent", "rewards", "has no __call__; a reward has initial_carry, __call__"),
    "another call": ("Eager", "rewards", "cannot be called as it has to be: __call__ takes 2 arguments beside self"),
    "no dataclass": ("Plain", "rewards", "is no dataclass"),
    "class of a narrow call": ("Narrow", "algorithms", "train takes 4 arguments beside self"),
    "another kind": ("Whole", "algorithms", "an algorithm has action_spaces, num_envs, train"),
    "no robot": ("Plain", "robots", "is no folder with a robot.toml"),
    "no command": ("UNFIT", "commands", "is no function"),
    "no such name": ("Nobody", "rewards", "cannot be imported"),
}


def test_unfit_target_is_told(subtests):
    """What it lacks, and what a thing of its kind has."""
    for case, (name, kind, told) in UNFIT.items():
        with subtests.test(case), pytest.MonkeyPatch.context() as monkeypatch:
            monkeypatch.setitem(__import__("sys").modules, "targets_of_a_test", __import__("sys").modules[__name__])
            assert told in why_unfit(_spec(f"targets_of_a_test:{name}", kind))


@pytest.mark.parametrize(("name", "kind"), [("Whole", "rewards"), ("Learner", "algorithms")])
def test_fit_target_is_not_complained_of(monkeypatch, name, kind):
    """A field without a default is a member too."""
    monkeypatch.setitem(__import__("sys").modules, "targets_of_a_test", __import__("sys").modules[__name__])
    assert why_unfit(_spec(f"targets_of_a_test:{name}", kind)) == ""


def test_missing_library_is_no_fault_of_the_target():
    """It is looked for, and not imported."""
    assert why_unfit(_spec("json.decoder:JSONDecoder", requires=("no_such_engine",))) == ""
    assert "has no" in why_unfit(_spec("json.decoder:Nothing", requires=("no_such_engine",)))


def test_built_thing_is_blamed_on_its_plugin():
    """Whoever builds one that lacks a member is told whose it is."""
    with pytest.raises(PluginError, match=r"Reward 'mine' of package cem-algo 0\.1 has no __call__"):
        require_members(_spec("a:b"), Silent())
    require_members(_spec("a:b"), Whole())


def test_member_that_only_the_object_has_counts():
    """Set when it is built."""

    @dataclass
    class Late:
        def __post_init__(self):
            self.unit, self.better = "", "higher"

        def __call__(self, trace):
            return None

    assert missing_members("metrics", Late()) == ""
    assert missing_members("metrics", Late).startswith("has no unit, better")
