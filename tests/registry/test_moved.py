"""Names of version 0.1: where they lead, what they warn of, and what is told of those that lead nowhere."""

import importlib
import json
import subprocess
import sys
import warnings
from importlib.util import find_spec
from pathlib import Path

import pytest

from harness.policy import Policy, load_policy
from harness.policy.uniform import Uniform
from harness.registry.moved import (
    GONE_IN,
    MODULES,
    NAMES,
    REPLACED,
    find_old_names,
    found_at,
    new_name,
    old_names_in,
    why_gone,
)

RECORD = Path(__file__).parents[1] / "compatibility/names_v0_1_0.json"
"""The public names of 0.1.0 by module: functions, classes, what ``__all__`` named, and constants that authors used.

Without the modules of commands and of reports, and without the single checks of the contract kit.
"""
OLD: dict[str, list[str]] = json.loads(RECORD.read_text(encoding="utf-8"))
OF_0_2 = {
    "harness": ["audit_dataset", "audit_rewards"],
    "harness.environment": ["Measure"],
    "harness.record.recording.recorded_training": ["RecordedTraining"],
    "harness.record.trace": ["Trace"],
    "harness.score.compare": ["compare_recordings"],
    "harness.score.open_recording": ["match_recordings", "open_recording"],
    "harness.score.recording": ["Chunk", "Recording"],
    "harness.score.rescore": ["RecordingScorer"],
    "harness.score.scorer": ["score_trace", "targets_touched"],
}
"""Names that only 0.2 had: those to which 0.2.0 sent whoever used an old one, and those of its own pages."""
EVERY = [f"{module}.{name}" for it in (OLD, OF_0_2) for module, names in it.items() for name in names]
MOVED = [old for old in EVERY if new_name(old) and not why_gone(old)]
GONE = [old for old in EVERY if why_gone(old)]
STAYED = [old for old in EVERY if old not in {*MOVED, *GONE}]


def _taken(old: str) -> tuple[object, list[str]]:
    """What an old name gives, and the lines of the warnings."""
    module, _, name = old.rpartition(".")
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        found = getattr(importlib.import_module(module), name)
    assert {it.category for it in seen} <= {DeprecationWarning}
    return found, [str(it.message) for it in seen]


@pytest.mark.parametrize("old", MOVED)
def test_old_name_gives_what_the_new_one_gives(old: str):
    """The same object, and one line that says what to write."""
    new = str(new_name(old))
    module, _, name = new.rpartition(".")
    found, told = _taken(old)
    assert found is getattr(importlib.import_module(module), name)
    assert told == [f"{old} moved: from {module} import {name} (the old name goes with {GONE_IN})"]


@pytest.mark.parametrize("old", GONE)
def test_name_that_works_no_more_says_what_took_its_place(old: str):
    """In the error of the import, in one line."""
    module, _, name = old.rpartition(".")
    instead = REPLACED.get(old) or REPLACED[module]
    with pytest.raises(ImportError) as caught:
        exec(f"from {module} import {name}", {})
    gone = module if module in REPLACED else old
    assert str(caught.value) == f"{gone} is gone: see {instead}, which is used in another way"


@pytest.mark.parametrize("old", STAYED)
def test_name_that_stayed_warns_of_nothing(old: str):
    """Every public name of 0.1.0 that no table has is where it was."""
    assert _taken(old)[1] == []


def test_each_case_is_there():
    """All three tests above have something to try, and each table is used."""
    assert (len(MOVED) > 150, len(GONE) > 20, len(STAYED) > 80) == (True, True, True)


@pytest.mark.parametrize("old", [*MODULES, *NAMES, *REPLACED])
def test_tables_hold_names_that_there_were(old: str):
    """In the version that this is about, or names that only 0.2 had."""
    assert old in OLD or old in OF_0_2 or old in EVERY


@pytest.mark.parametrize("old", [*NAMES, *MODULES])
def test_no_name_is_old_and_new(old: str):
    """One that leads to itself, or to another old one, would never end."""
    new = {**MODULES, **NAMES}[old]
    assert new_name(new) is None
    assert not why_gone(new)


@pytest.mark.parametrize("old", MODULES)
def test_old_modules_stand_nowhere(old: str):
    """What is there needs no line, and an old module would hide it."""
    spec = find_spec(old)
    assert spec is not None
    assert spec.origin == MODULES[old]


@pytest.mark.parametrize("instead", sorted(set(REPLACED.values())))
def test_what_took_a_place_is_there(instead: str):
    """A module, a name of a module, or a member of a class."""
    place, _, name = instead.rpartition(".")
    try:
        importlib.import_module(instead)
    except ImportError:
        holder = found_at(place) if place.rpartition(".")[2][:1].isupper() else importlib.import_module(place)
        assert hasattr(holder, name) or name in holder.__annotations__


def test_names_that_never_were_are_told_by_python():
    """In an old module and in one that is there."""
    for module in ("harness.kinematics", "harness.robot"):
        with pytest.raises(ImportError, match="cannot import name 'never'"):
            exec(f"from {module} import never", {})


def test_a_room_still_finds_its_modules():
    """``from harness.transfer import matrix`` asks the room first."""
    namespace: dict[str, object] = {}
    exec("from harness.transfer import matrix", namespace)
    assert namespace["matrix"] is sys.modules["harness.transfer.matrix"]


def test_to_find_old_names_twice_is_to_find_them_once():
    """Nothing is added to what Python asks for modules."""
    before = list(sys.meta_path)
    find_old_names()
    assert sys.meta_path == before


def test_script_is_told_on_its_own_line():
    """Python shows the warning to whoever runs the script, with the line that imports."""
    script = "import harness\n\nfrom harness.kinematics import forward\n"
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    told = "DeprecationWarning: harness.kinematics.forward moved: from harness.authoring import forward"
    assert ended.stderr.startswith(f"<string>:3: {told} (the old name goes with {GONE_IN})")


READ = {
    "import harness.kinematics": "harness.kinematics moved: import harness.robot.kinematics",
    "import harness.kinematics as k, json": "harness.kinematics moved: import harness.robot.kinematics",
    "from harness import trace": "harness.trace moved: import harness.record.trace",
    "from harness.trace import Trace": "harness.trace.Trace moved: from harness.log import Log",
    "def f():\n    from harness.make import make_env": "harness.make.make_env moved: from harness import make_env",
}


@pytest.mark.parametrize(("source", "told"), READ.items())
def test_old_names_are_read_in_a_source(source: str, told: str):
    """Without importing it, inside functions too."""
    assert old_names_in(source) == [f"{told} (the old name goes with {GONE_IN})"]


def test_names_that_are_gone_are_read_in_a_source():
    """Those too, each once."""
    source = "from harness.workers import Order\nfrom harness.workers import Order\n"
    assert old_names_in(source) == [
        "harness.workers.Order is gone: see harness.authoring.run_jobs, which is used in another way"
    ]


@pytest.mark.parametrize(
    "source",
    ["from . import kinematics", "from .harness import trace", "import json", "from harness.reward import Sample"],
)
def test_other_names_are_no_old_ones(source: str):
    """Of the package itself, of others, and those that are where they were."""
    assert old_names_in(source) == []


def test_policy_load_is_load_policy(tmp_path: Path):
    """A policy that was saved comes back by the old name, with a warning."""
    Uniform((-1.0,), (1.0,), "mine").save(tmp_path / "policy")
    with pytest.warns(DeprecationWarning, match="^harness.policy.Policy.load moved: from harness.policy import load_p"):
        policy = Policy.load(tmp_path / "policy")
    assert type(policy) is type(load_policy(tmp_path / "policy"))


def test_warning_of_an_object_stands_at_the_line_that_used_it(tmp_path: Path):
    """Not in the harness."""
    Uniform((-1.0,), (1.0,), "mine").save(tmp_path / "policy")
    with pytest.warns(DeprecationWarning, match="moved") as seen:
        Policy.load(tmp_path / "policy")
    assert seen[0].filename == __file__
