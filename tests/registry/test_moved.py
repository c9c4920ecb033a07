"""Names of version 0.2: where they lead, what they warn of, and what is told of those that lead nowhere."""

import importlib
import subprocess
import sys
import warnings
from importlib.util import find_spec

import pytest

from harness.registry.moved import (
    GONE_IN,
    MODULES,
    NAMES,
    REPLACED,
    find_old_names,
    new_name,
    old_names_in,
    why_gone,
)

OLD = {
    "harness": ["audit_dataset", "audit_rewards"],
    "harness.environment": ["Measure"],
    "harness.metric": ["Metric"],
    "harness.pytest_plugin": ["pytest_configure"],
    "harness.record.recording.recorded_training": ["RecordedTraining"],
    "harness.record.trace": ["Trace"],
    "harness.score.compare": ["compare_recordings"],
    "harness.score.open_recording": ["match_recordings", "open_recording"],
    "harness.score.recording": ["Chunk", "Recording"],
    "harness.score.rescore": ["RecordingScorer"],
    "harness.score.scorer": ["score_trace", "targets_touched"],
    "harness.testing": ["Check", "IdealSimulator", "REWARD_CHECKS", "check", "check_reward", "violations"],
    "harness.testing.metrics.traces": ["recorded_trace"],
    "harness.testing.rewards.samples": ["edge_samples", "random_samples"],
    "harness.testing.rewards.standard_array": ["StandardArray"],
    "harness.testing.simulators.simulations": ["NUM_ENVS", "opened"],
    "harness.testing.unity_player": ["write_unity_player"],
    "harness.transfer.jobs": ["transfer"],
}
"""Names that 0.2.0 had, by module: those of its pages, and those to which it sent whoever used a name of 0.1."""
EVERY = [f"{module}.{name}" for module, names in OLD.items() for name in names]
MOVED = [old for old in EVERY if new_name(old) and not why_gone(old)]
GONE = [old for old in EVERY if why_gone(old)]


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


@pytest.mark.parametrize("old", [*MODULES, *NAMES, *REPLACED])
def test_tables_hold_names_that_there_were(old: str):
    """In the version that this is about; each of these is moved or gone."""
    assert old in OLD or old in EVERY
    assert {*MOVED, *GONE} == {*EVERY}


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
    """A name of a module."""
    place, _, name = instead.rpartition(".")
    assert hasattr(importlib.import_module(place), name)


def test_names_that_never_were_are_told_by_python():
    """In an old module and in one that is there."""
    for module in ("harness.metric", "harness.score.compare"):
        with pytest.raises(ImportError, match="cannot import name 'never'"):
            exec(f"from {module} import never", {})


def test_to_find_old_names_twice_is_to_find_them_once():
    """Nothing is added to what Python asks for modules."""
    before = list(sys.meta_path)
    find_old_names()
    assert sys.meta_path == before


def test_script_is_told_on_its_own_line():
    """Python shows the warning to whoever runs the script, with the line that imports."""
    script = "import harness\n\nfrom harness.record.trace import Trace\n"
    ended = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    told = "DeprecationWarning: harness.record.trace.Trace moved: from harness.log import Log"
    assert ended.stderr.startswith(f"<string>:3: {told} (the old name goes with {GONE_IN})")


READ = {
    "import harness.metric": "harness.metric moved: import harness.measure",
    "import harness.metric as k, json": "harness.metric moved: import harness.measure",
    "from harness import metric": "harness.metric moved: import harness.measure",
    "from harness.metric import Metric": "harness.metric.Metric moved: from harness.measure import Measure",
    "def f():\n    from harness.record.trace import Trace": (
        "harness.record.trace.Trace moved: from harness.log import Log"
    ),
}


@pytest.mark.parametrize(("source", "told"), READ.items())
def test_old_names_are_read_in_a_source(source: str, told: str):
    """Without importing it, inside functions too."""
    assert old_names_in(source) == [f"{told} (the old name goes with {GONE_IN})"]


def test_names_that_are_gone_are_read_in_a_source():
    """Those too, each once."""
    source = "from harness.score.recording import Chunk\nfrom harness.score.recording import Chunk\n"
    assert old_names_in(source) == [
        "harness.score.recording.Chunk is gone: see harness.log.Log, which is used in another way"
    ]


@pytest.mark.parametrize(
    "source",
    ["from . import metric", "from .harness import metric", "import json", "from harness.reward import Sample"],
)
def test_other_names_are_no_old_ones(source: str):
    """Of the package itself, of others, and those that are where they were."""
    assert old_names_in(source) == []


def test_program_is_started_by_its_old_name():
    """By ``python -m``, after a warning: the same one, which says what it lacks where the extra is not installed."""
    command = [sys.executable, "-m", "harness.testing.unity_player", "--help"]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert "harness.testing.unity_player moved: import harness_plugins.kit.unity_player" in ended.stderr
    assert "usage: " in ended.stdout or "No module named 'mlagents_envs'" in ended.stderr or "'grpc'" in ended.stderr
