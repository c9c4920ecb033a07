"""What a plugin of an earlier release is answered: it works with a warning, or hears what to write."""

import importlib
import re

import numpy as np
import pytest

import harness.executor
from harness.errors import UsageError
from harness.face import INSTEAD, LEFT, MOVED
from harness.log import trace_of
from harness.task import ReachTask


@pytest.mark.parametrize(("old", "new"), MOVED.items())
def test_moved_name_is_the_new_one_with_a_warning(old, new):
    """Of 0.3 and before: it works, and says until when."""
    (before, name), (home, after) = (it.rsplit(".", 1) for it in (old, new))
    instead = INSTEAD.get(old, f"write `from {home} import {after}`")
    with pytest.warns(DeprecationWarning, match=re.escape(f"{old} works until fd100-harness 0.6: {instead}")):
        found = getattr(importlib.import_module(before), name)
    assert found is getattr(importlib.import_module(home), after)


@pytest.mark.parametrize("old", [*MOVED, "harness_plugins.kit.check_reward", "harness_plugins.kit.REWARD_CHECKS"])
def test_warning_names_the_line_that_asked(old):
    """Not the harness: Python shows a warning of its author's own file alone."""
    module, _, name = old.rpartition(".")
    with pytest.warns(DeprecationWarning, match="works until") as told:
        getattr(importlib.import_module(module), name)
    assert {it.filename for it in told} == {__file__}


@pytest.mark.parametrize(
    "old",
    ["harness.log.REWARD", "harness.measure.is_share", "harness.reach.way_to_mount", "harness.screen.CANNOT_TELL"],
)
def test_name_that_no_list_had_works_with_a_warning(old):
    """Of a page of 0.3, and on none of today."""
    module, _, name = old.rpartition(".")
    with pytest.warns(DeprecationWarning, match=f"{re.escape(old)} works until fd100-harness 0.6: "):
        assert getattr(importlib.import_module(module), name)


def test_module_that_is_no_more_is_an_attribute():
    """After `import harness.reach`, as Python has it."""
    import harness.reach

    with pytest.warns(DeprecationWarning, match="works until"):
        assert harness.reach.ReachTask is ReachTask


def test_names_of_a_face_are_listed():
    """As the Python prompt completes them, also those that are looked up when they are first used."""
    assert dir(harness.executor) == harness.executor.__all__


@pytest.mark.parametrize("name", LEFT)
def test_name_that_left_says_what_to_write(name):
    """Imported as a module, or from the module that had it."""
    home, _, last = name.rpartition(".")
    with pytest.raises(ImportError, match="is no longer in fd100-harness: ") as caught:
        exec(f"from {home} import {last}")
    assert LEFT[name] in str(caught.value)


def test_columns_of_a_trace_are_names_now():
    """A metric of 0.1 or 0.2 read `trace.columns["distance"]`, and `trace.facts.horizon`."""
    log = trace_of({name: np.zeros(2, int) for name in ("env", "episode", "distance", "reward")})
    with pytest.raises(UsageError, match=r"write log\['distance'\] for the column"):
        log.columns["distance"]
    assert log.columns[0] == "env"
    with pytest.raises(AttributeError, match=r"write log\.facts\.episodes\.horizon"):
        _ = log.facts.horizon


def test_unknown_module_is_unknown():
    """Python's own sentence, of what never was."""
    with pytest.raises(ModuleNotFoundError, match=r"No module named 'harness\.no_such'"):
        importlib.import_module("harness.no_such")
