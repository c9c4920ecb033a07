"""The face of a room or a module: names that others ask for, each looked up in its own module when it is first used.

Names of earlier releases are known here too: one that moved works for two releases and warns, one that left says what
to write.
"""

import ast
import importlib
import sys
import warnings
from collections.abc import Callable, Mapping
from functools import partial
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

_KEPT = """
harness.authoring   harness.algorithm  act_for pack_generator restore_generator
harness.authoring   harness.executor   Part add_parts parts_of run_job run_jobs
harness.authoring   harness.policy     Categorical Deterministic Gaussian Greedy SquashedGaussian layer_weights
harness.authoring   harness.reward     ObservedReward WrappedReward
harness.authoring   harness.robot      forward link_frames reach_position
harness.authoring   harness.simulator  GroundContact ServoTrack Substeps servo_of
harness.measure     harness.log        Measure
harness.progress    harness.algorithm  Progress Ring TrainingState as_state under
harness.reach       harness.task       ReachTask place_box
harness.reach       harness.reward     Pay
harness.results     harness            load_results
harness.screen      harness.executor   Screen Screened
harness.section     harness.results    Section Shown
harness.tracker     harness.executor   Outcome Track TrackedCell Tracker
harness.authoring   harness.authoring.folder_parts     add_part
harness.authoring   harness.experiment.jobs            events_of order_of
harness.log         harness.log.facts                  Unit
harness.policy      harness.policy.inverse_kinematics  InverseKinematics
harness.reach       harness.robot.robot                FD100_REACH
harness.reward      harness.reward.steps               MissingField
harness.robot.inverse_kinematics  harness.robot        reach_position
harness_plugins.kit harness_plugins.kit.contract       Check check violations
"""
"""In each line: a module that had names, the module that has them now, and these names."""
_FILES = {
    "harness.log": "harness.log.log",
    "harness.measure": "harness.log.measure",
    "harness.progress": "harness.record.progress",
    "harness.reach": "harness.env.reach_task",
    "harness.reward": "harness.reward.reward",
    "harness.screen": "harness.experiment.screening",
}
"""By module that had more names, or is no more, the one that has all of them."""


def _by_name(rows: Mapping[str, str]) -> dict[str, str]:
    return {name: text for text, names in rows.items() for name in names.split()}


MOVED = {
    **{
        f"{before}.{name}": f"{now}.{name}"
        for before, now, *names in map(str.split, _KEPT.strip().splitlines())
        for name in names
    },
    **_by_name(
        {
            "harness.log.Measure": "harness.metric.Metric",
            "harness.reward.Given": "harness.environment.Measure",
            "harness_plugins.sb3.policy_from": "harness_plugins.sb3.categorical harness_plugins.sb3.deterministic "
            "harness_plugins.sb3.gaussian harness_plugins.sb3.greedy harness_plugins.sb3.squashed_gaussian",
        }
    ),
}
"""By name, where it is now. They leave with 0.6."""
INSTEAD = _by_name(
    {
        "`in_memory` refuses what is larger": "harness.log.LARGEST",
        "`robot.scale` is the arm's reach as a share of it": "harness.reach.FD100_REACH",
        "`run_jobs([job], 1, on_event)` does a job anywhere": "harness.authoring.order_of",
        "`run_jobs` gives the same events to a function": "harness.authoring.events_of",
        "a function that raises AssertionError is a check": "harness_plugins.kit.Check harness_plugins.kit.check",
        "annotate the field with `harness.reward.Pay`": "harness.reward.LARGEST_FACTOR",
        "call each of `CHECKS[kind]`": "harness_plugins.kit.violations",
        "catch `harness.errors.UsageError`": "harness.reward.MissingField",
        "the algorithm `ik` yields one": "harness.policy.InverseKinematics",
        "write `'CANNOT TELL'`": "harness.screen.CANNOT_TELL",
        "write `add_parts(folder, [part])`": "harness.authoring.add_part",
    }
)
"""What to write where a name has no place that stays."""
LEFT = _by_name(
    {
        "`harness.policy.load_policy(folder)` reads what `Policy.save` writes": "harness.policy.CARD "
        "harness.policy.FORMAT harness.policy.KINDS harness.policy.Network harness.policy.WEIGHTS",
        "a carry is an array, or a tuple of arrays, with a row for each episode: index it": "harness.reward.Selection "
        "harness.reward.put harness.reward.replace_where harness.reward.take",
        "search with a library of your choice around `harness.run`": "harness.tune",
        "the checks of plugins are in harness_plugins.kit, as in `from harness_plugins.kit import "
        "check_contract`": "harness.testing",
        "time two libraries with pytest-benchmark, in a test of yours": "harness_plugins.sb3.bare_training",
        "type `harness audit --reward NAME`": "harness.audit_rewards",
        "type `harness audit FILE`": "harness.audit_dataset",
        "type `harness check NAME`": "harness_plugins.kit.DESCRIPTION_CHECKS harness_plugins.kit.SCREEN_CHECKS "
        "harness_plugins.kit.SECTION_CHECKS harness_plugins.kit.check_description_format "
        "harness_plugins.kit.check_screen harness_plugins.kit.check_section",
        "type `harness export FOLDER --format NAME` and load what it wrote": "harness_plugins.kit.EXPORT_CHECKS "
        "harness_plugins.kit.check_export",
        "type `harness score FILE`": "harness.score.open_recording",
        "type `harness transfer`": "harness.transfer",
        "write `from harness.log import Log`; log['distance'] is a column, and `harness.log.trace_of(columns)` makes a "
        "log for a test": "harness.record.trace.Trace",
    }
)
"""By name, what to write or to type in its place."""
GONE = [
    "harness.measure",
    "harness.metric",
    "harness.progress",
    "harness.reach",
    "harness.robot.inverse_kinematics",
    "harness.score.open_recording",
    "harness.screen",
    "harness.section",
    "harness.testing",
    "harness.tracker",
    "harness.transfer",
    "harness.transfer.jobs",
    "harness.tune",
    "harness.tune.tune",
]
"""Modules that are no more."""


def lookup(module: str, name: str, level: int = 3) -> Any:
    """What an earlier release had under a name that a module has no more.

    Args:
        module: The module's name.
        name: What is asked of it.
        level: See `warn_of`.

    Raises:
        ImportError: It left; says what to write in its place.
        AttributeError: There never was such a name.
    """
    full = f"{module}.{name}"
    for left in (full, module, module.rpartition(".")[0]):
        if left in LEFT and not name.startswith("__"):
            raise ImportError(f"{left} is no longer in fd100-harness: {LEFT[left]}. docs/plugins.md tells what stays")
    if full not in MOVED and (module not in _FILES or name.startswith("__")):
        raise AttributeError(f"module '{module}' has no attribute '{name}'")
    home, _, new = MOVED.get(full, f"{_FILES.get(module)}.{name}").rpartition(".")
    found = getattr(importlib.import_module(home), new)
    stays = f"write `from {home} import {new}`" if full in MOVED else "it is not public, so copy what you need of it"
    warn_of(full, INSTEAD.get(full, stays), level)
    return found


def warn_of(name: str, instead: str, level: int = 4) -> None:
    """Say that a name leaves, and what to write in its place, of the line that asked for it, `level` frames away."""
    warnings.warn(f"{name} works until fd100-harness 0.6: {instead}", DeprecationWarning, stacklevel=level)


def know_earlier_modules() -> None:
    """Have Python know the modules that are no more, whose names are looked up when they are used."""
    for name in GONE:
        module = sys.modules[name] = ModuleType(name)
        vars(module).update(__spec__=ModuleSpec(name, None), __getattr__=partial(lookup, name))
        if name not in LEFT:  # else `from harness import testing` has to say what to write
            vars(sys.modules["harness"])[name.removeprefix("harness.")] = module


def face_of(module: str, *own: str) -> tuple[list[str], Callable[[str], Any]]:
    """A module's ``__all__`` and ``__getattr__``: the names that it imports as ``X as X``, which makes them public.

    Those that it imports for type checkers alone are looked up when they are first used. So each name is written once,
    and importing the module imports nothing heavy.

    Args:
        module: The module's name.
        own: What it defines itself and makes public.
    """
    known = vars(sys.modules[module])
    homes = {
        it.name: "." * node.level + (node.module or "")
        for node in ast.walk(ast.parse(Path(known["__file__"]).read_text(encoding="utf-8")))
        if isinstance(node, ast.ImportFrom)
        for it in node.names
        if it.asname
    }

    def look_up(name: str) -> Any:
        if name not in homes:
            return lookup(module, name, 4)
        return getattr(importlib.import_module(homes[name], module), name)

    names = sorted([*homes, *own])
    known["__dir__"] = lambda: names
    return names, look_up
