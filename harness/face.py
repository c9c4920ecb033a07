"""The face of a room or a module: names that others ask for, each looked up in its own module when it is first used.

Names of earlier releases are known here too: one that moved works for two releases and warns, one that left says what
to write.
"""

import ast
import importlib
import sys
import warnings
from collections.abc import Callable
from functools import partial
from importlib.machinery import ModuleSpec
from pathlib import Path
from types import ModuleType
from typing import Any

MOVED = {
    "harness.authoring.Categorical": "harness.policy.Categorical",
    "harness.authoring.Deterministic": "harness.policy.Deterministic",
    "harness.authoring.Gaussian": "harness.policy.Gaussian",
    "harness.authoring.Greedy": "harness.policy.Greedy",
    "harness.authoring.SquashedGaussian": "harness.policy.SquashedGaussian",
    "harness.authoring.add_part": "harness.authoring.folder_parts.add_part",
    "harness.authoring.events_of": "harness.experiment.jobs.events_of",
    "harness.authoring.forward": "harness.robot.forward",
    "harness.authoring.link_frames": "harness.robot.link_frames",
    "harness.authoring.order_of": "harness.experiment.jobs.order_of",
    "harness.authoring.reach_position": "harness.robot.reach_position",
    "harness.authoring.servo_of": "harness.simulator.servo_of",
    "harness.environment.Measure": "harness.reward.Given",
    "harness.metric.Metric": "harness.measure.Measure",
    "harness.results.load_results": "harness.load_results",
    "harness.robot.inverse_kinematics.reach_position": "harness.robot.reach_position",
    "harness_plugins.sb3.categorical": "harness_plugins.sb3.policy_from",
    "harness_plugins.sb3.deterministic": "harness_plugins.sb3.policy_from",
    "harness_plugins.sb3.gaussian": "harness_plugins.sb3.policy_from",
    "harness_plugins.sb3.greedy": "harness_plugins.sb3.policy_from",
    "harness_plugins.sb3.squashed_gaussian": "harness_plugins.sb3.policy_from",
}
"""By name, where it is now. They leave with 0.6."""
INSTEAD = {
    "harness.authoring.add_part": "write `add_parts(folder, [part])`",
    "harness.authoring.events_of": "`run_jobs` gives the same events to a function",
    "harness.authoring.order_of": "`run_jobs([job], 1, on_event)` does a job anywhere",
}
"""What to write where a name has no place that stays."""
_KIT = "the checks of plugins are in harness_plugins.kit, as in `from harness_plugins.kit import check_contract`"
LEFT = {
    **dict.fromkeys(
        ("harness.policy.CARD", "harness.policy.FORMAT", "harness.policy.WEIGHTS", "harness.policy.Network"),
        "`harness.policy.load_policy(folder)` reads what `Policy.save` writes",
    ),
    **dict.fromkeys(
        ("harness.reward.put", "harness.reward.replace_where", "harness.reward.take", "harness.reward.Selection"),
        "a carry is an array, or a tuple of arrays, with a row for each episode: index it",
    ),
    "harness.audit_dataset": "type `harness audit FILE`",
    "harness.audit_rewards": "type `harness audit --reward NAME`",
    "harness.record.trace.Trace": "write `from harness.log import Log`; log['distance'] is a column, and "
    "`harness.authoring.trace_of(columns)` makes a log for a test",
    "harness.score.open_recording": "type `harness score FILE`",
    "harness.testing": _KIT,
    "harness_plugins.kit.check_export": "type `harness export FOLDER --format NAME` and load what it wrote",
    "harness_plugins.sb3.bare_training": "time two libraries with pytest-benchmark, in a test of yours",
    "harness.transfer": "type `harness transfer`",
    "harness.tune": "search with a library of your choice around `harness.run`",
}
"""By name, what to write or to type in its place."""
GONE = (
    *("harness.metric", "harness.robot.inverse_kinematics", "harness.score.open_recording", "harness.testing"),
    *("harness.transfer", "harness.transfer.jobs", "harness.tune", "harness.tune.tune"),
)
"""Modules that are no more."""


def lookup(module: str, name: str) -> Any:
    """What an earlier release had under a name that a module has no more.

    Raises:
        ImportError: It left; says what to write in its place.
        AttributeError: There never was such a name.
    """
    full = f"{module}.{name}"
    for left in (full, module, module.rpartition(".")[0]):
        if left in LEFT and not name.startswith("__"):
            raise ImportError(f"{left} is no longer in fd100-harness: {LEFT[left]}. docs/plugins.md tells what stands")
    if full not in MOVED:
        raise AttributeError(f"module '{module}' has no attribute '{name}'")
    home, _, new = MOVED[full].rpartition(".")
    warn_of(full, INSTEAD.get(full, f"write `from {home} import {new}`"))
    return getattr(importlib.import_module(home), new)


def warn_of(name: str, instead: str) -> None:
    """Say that a name, which a module's ``__getattr__`` just looked up, leaves, and what to write in its place."""
    warnings.warn(f"{name} works until fd100-harness 0.6: {instead}", DeprecationWarning, stacklevel=4)


def know_earlier_modules() -> None:
    """Have Python know the modules that are no more, whose names are looked up when they are used."""
    for name in GONE:
        module = sys.modules[name] = ModuleType(name)
        vars(module).update(__spec__=ModuleSpec(name, None), __getattr__=partial(lookup, name))


def face_of(module: str, path: str) -> tuple[list[str], Callable[[str], Any]]:
    """A module's ``__all__`` and ``__getattr__``: the names that it imports as ``X as X``, which makes them public.

    Those that it imports for type checkers alone are looked up when they are first used. So each name is written once,
    and importing the module imports nothing heavy.

    Args:
        module: The module's name.
        path: The module's own file.
    """
    imports = [
        it for it in ast.walk(ast.parse(Path(path).read_text(encoding="utf-8"))) if isinstance(it, ast.ImportFrom)
    ]
    homes = {it.name: "." * node.level + (node.module or "") for node in imports for it in node.names if it.asname}

    def look_up(name: str) -> Any:
        if name not in homes:
            return lookup(module, name)
        return getattr(importlib.import_module(homes[name], module), name)

    return sorted(homes), look_up
