"""Names of version 0.2 that moved: they work for one more version, with a warning that says the new one.

`harness` calls `find_old_names` when it is imported. From then on ``from harness.record.trace import Trace`` gives what
``from harness.log import Log`` gives, and a `DeprecationWarning`. docs/renamed.md shows the tables below.
"""

import ast
import importlib
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from importlib.machinery import ModuleSpec
from types import CodeType, MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, cast

import wrapt

if TYPE_CHECKING:
    from importlib.abc import Loader

GONE_IN = "0.4.0"
"""The version in which the old names are gone."""

MODULES: Mapping[str, str] = MappingProxyType(
    {
        "harness.metric": "harness.measure",
        "harness.pytest_plugin": "harness_plugins.kit.pytest_plugin",
        "harness.score.open_recording": "harness.score.open_steps",
        "harness.testing": "harness_plugins.kit",
        "harness.testing.metrics.traces": "harness_plugins.kit.metrics",
        "harness.testing.rewards.samples": "harness_plugins.kit.reward_samples",
        "harness.testing.rewards.standard_array": "harness_plugins.kit.reward_samples",
        "harness.testing.simulators.simulations": "harness_plugins.kit.simulators.simulations",
        "harness.testing.unity_player": "harness_plugins.kit.unity_player",
        "harness.transfer.jobs": "harness_plugins.transfer.jobs",
    }
)
"""The module in which the names of each old module stand now, unless `NAMES` or `REPLACED` has them."""

NAMES: Mapping[str, str] = MappingProxyType(
    {
        "harness.audit_dataset": "harness_plugins.audit.audit_dataset",
        "harness.audit_rewards": "harness_plugins.audit.audit_rewards",
        "harness.environment.Measure": "harness.reward.Given",
        "harness.metric.Metric": "harness.measure.Measure",
        "harness.record.trace.Trace": "harness.log.Log",
        "harness.score.compare.compare_recordings": "harness.score.compare.compare_logs",
        "harness.score.open_recording.match_recordings": "harness.score.open_steps.match_steps",
        "harness.score.open_recording.open_recording": "harness.score.open_steps.open_steps",
        "harness.score.scorer.targets_touched": "harness.reward.row_steps.targets_touched",
    }
)
"""The new name of each old one whose module is still there, or which stands elsewhere than the rest of its module."""

REPLACED: Mapping[str, str] = MappingProxyType(
    {
        "harness.record.recording.recorded_training.RecordedTraining": "harness.log.Log",
        "harness.score.recording": "harness.log.Log",
        "harness.score.rescore.RecordingScorer": "harness.score.scorer.Payer",
        "harness.score.scorer.score_trace": "harness.score.scorer.pay_log",
    }
)
"""What takes the place of each old name that does not work, because the new one is used in another way."""

ALGORITHMS: Mapping[str, str] = MappingProxyType({"sac": "sb3-sac"})
"""The present name of each algorithm whose old name means another one now; cells of 0.2 have the old name."""


def find_old_names() -> None:
    """Make Python find the old names: modules that are gone, and names that are gone from modules that are there."""
    if not any(isinstance(finder, _OldModules) for finder in sys.meta_path):
        sys.meta_path.append(_OldModules())  # the last: what there is comes first
    for module in {name.rpartition(".")[0] for name in [*NAMES, *REPLACED]} - MODULES.keys():
        wrapt.when_imported(module)(_give_old_names)


def new_name(old: str) -> str | None:
    """The present name of one that still works, ``harness.log.Log`` of ``harness.record.trace.Trace``; None of others.

    Args:
        old: The dotted name of a module, or of something in a module.
    """
    module, _, name = old.rpartition(".")
    within = f"{MODULES[module]}.{name}" if module in MODULES else None
    return NAMES.get(old) or MODULES.get(old) or within


def why_gone(old: str) -> str:
    """One line that says what takes the place of a name that does not work any more; empty of every other name."""
    instead = REPLACED.get(old) or REPLACED.get(old.rpartition(".")[0])
    return f"{old} is gone: see {instead}, which is used in another way" if instead else ""


def old_names_in(source: str) -> list[str]:
    """A line for each old name that a Python source imports.

    Raises:
        SyntaxError: It is no Python.
    """
    names = dict.fromkeys(name for node in ast.walk(ast.parse(source)) for name in _imported(node))
    return [line for name in names if (line := why_gone(name) or _moved(name))]


def _moved(old: str) -> str:
    """One line that says what to write in place of an old name; empty of every other."""
    new = new_name(old)
    if new is None:
        return ""
    module, _, name = new.rpartition(".")
    instead = f"import {new}" if new in MODULES.values() else f"from {module} import {name}"
    return f"{old} moved: {instead} (the old name goes with {GONE_IN})"


def _imported(node: ast.AST) -> Iterator[str]:
    """The dotted names that a statement imports."""
    if isinstance(node, ast.Import):
        yield from (alias.name for alias in node.names)
    elif isinstance(node, ast.ImportFrom) and not node.level:
        yield from (f"{node.module}.{alias.name}" for alias in node.names)


class _OldModules:
    """Finds the modules that are gone: empty ones, which look their names up where these stand now.

    It is a finder and a loader without their base classes, whose module takes 5 ms of every start.
    """

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        if gone := why_gone(name):
            raise ModuleNotFoundError(gone, name=name)
        is_parent = any(old.startswith(f"{name}.") for old in MODULES)
        if name not in MODULES and not is_parent:
            return None
        return ModuleSpec(name, cast("Loader", self), origin=MODULES.get(name), is_package=is_parent)

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return None  # Python makes it

    def exec_module(self, module: ModuleType) -> None:
        _give_old_names(module)

    def get_code(self, name: str) -> CodeType:
        """What ``python -m`` runs of an old name: the program that is called otherwise now."""
        start = f"import runpy; runpy.run_module({MODULES[name]!r}, run_name='__main__', alter_sys=True)"
        return compile(f"import warnings; warnings.warn({_moved(name)!r}, DeprecationWarning); {start}", name, "exec")


def _give_old_names(module: ModuleType) -> None:
    own = vars(module).get("__getattr__")

    def look_up(name: str) -> Any:
        old = f"{module.__name__}.{name}"
        if gone := why_gone(old):
            raise ImportError(gone, name=module.__name__)
        new = None if name.startswith("__") else new_name(old)
        if new is None and own is not None:
            return own(name)
        if new is None:
            raise AttributeError(f"module '{module.__name__}' has no attribute '{name}'")
        place, _, present = new.rpartition(".")
        value = getattr(importlib.import_module(place), present)
        warnings.warn(_moved(old), DeprecationWarning, stacklevel=2)  # at the line that used it
        return value

    vars(module)["__getattr__"] = look_up
