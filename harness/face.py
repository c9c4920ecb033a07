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

_NAMES = {
    "harness.authoring": {
        "harness.algorithm": "act_for pack_generator restore_generator",
        "harness.executor": "Part add_parts parts_of run_job run_jobs",
        "harness.policy": "Categorical Deterministic Gaussian Greedy SquashedGaussian layer_weights",
        "harness.reward": "ObservedReward WrappedReward",
        "harness.robot": "forward link_frames reach_position",
        "harness.simulator": "GroundContact ServoTrack Substeps servo_of",
    },
    "harness.measure": {"harness.log": "Measure"},
    "harness.progress": {"harness.algorithm": "Progress Ring TrainingState as_state under"},
    "harness.reach": {"harness.task": "ReachTask place_box", "harness.reward": "Pay"},
    "harness.screen": {"harness.executor": "Screen Screened"},
    "harness.section": {"harness.results": "Section Shown"},
    "harness.tracker": {"harness.executor": "Outcome Track TrackedCell Tracker"},
}
"""By module that had them, the names of each module that has them now."""
MOVED = {
    **{
        f"{before}.{name}": f"{now}.{name}"
        for before, homes in _NAMES.items()
        for now, names in homes.items()
        for name in names.split()
    },
    **{
        f"harness_plugins.sb3.{kind}": "harness_plugins.sb3.policy_from"
        for kind in ("categorical", "deterministic", "gaussian", "greedy", "squashed_gaussian")
    },
    "harness.authoring.add_part": "harness.authoring.folder_parts.add_part",
    "harness.authoring.events_of": "harness.experiment.jobs.events_of",
    "harness.authoring.order_of": "harness.experiment.jobs.order_of",
    "harness.environment.Measure": "harness.reward.Given",
    "harness.log.LARGEST": "harness.log.log.LARGEST",
    "harness.policy.InverseKinematics": "harness.policy.inverse_kinematics.InverseKinematics",
    "harness.metric.Metric": "harness.log.Measure",
    "harness.reach.FD100_REACH": "harness.robot.robot.FD100_REACH",
    "harness.reward.LARGEST_FACTOR": "harness.reward.reward.LARGEST_FACTOR",
    "harness.results.load_results": "harness.load_results",
    "harness.robot.inverse_kinematics.reach_position": "harness.robot.reach_position",
    "harness_plugins.kit.violations": "harness_plugins.kit.contract.violations",
}
"""By name, where it is now. They leave with 0.6."""
INSTEAD = {
    "harness.authoring.add_part": "write `add_parts(folder, [part])`",
    "harness.authoring.events_of": "`run_jobs` gives the same events to a function",
    "harness.authoring.order_of": "`run_jobs([job], 1, on_event)` does a job anywhere",
    "harness.log.LARGEST": "`in_memory` refuses what is larger",
    "harness.policy.InverseKinematics": "the algorithm `ik` yields one",
    "harness.reach.FD100_REACH": "`robot.scale` is the arm's reach as a share of it",
    "harness.reward.LARGEST_FACTOR": "annotate the field with `harness.reward.Pay`",
    "harness_plugins.kit.violations": "call each of `CHECKS[kind]`",
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
    "`harness.log.trace_of(columns)` makes a log for a test",
    "harness.score.open_recording": "type `harness score FILE`",
    "harness.testing": _KIT,
    "harness_plugins.kit.check_export": "type `harness export FOLDER --format NAME` and load what it wrote",
    "harness_plugins.sb3.bare_training": "time two libraries with pytest-benchmark, in a test of yours",
    "harness.transfer": "type `harness transfer`",
    "harness.tune": "search with a library of your choice around `harness.run`",
}
"""By name, what to write or to type in its place."""
GONE = (
    *(set(_NAMES) - {"harness.authoring"}),
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


def face_of(module: str, path: str, *own: str) -> tuple[list[str], Callable[[str], Any]]:
    """A module's ``__all__`` and ``__getattr__``: the names that it imports as ``X as X``, which makes them public.

    Those that it imports for type checkers alone are looked up when they are first used. So each name is written once,
    and importing the module imports nothing heavy.

    Args:
        module: The module's name.
        path: The module's own file.
        own: What it defines itself and makes public.
    """
    imports = [
        it for it in ast.walk(ast.parse(Path(path).read_text(encoding="utf-8"))) if isinstance(it, ast.ImportFrom)
    ]
    homes = {it.name: "." * node.level + (node.module or "") for node in imports for it in node.names if it.asname}

    def look_up(name: str) -> Any:
        if name not in homes:
            return lookup(module, name)
        return getattr(importlib.import_module(homes[name], module), name)

    return sorted([*homes, *own]), look_up
