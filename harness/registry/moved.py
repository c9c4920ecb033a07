"""Names of versions 0.1 and 0.2 that moved: they work for one more version, with a warning that says the new one.

`harness` calls `find_old_names` when it is imported. From then on ``from harness.kinematics import forward`` gives what
``from harness.authoring import forward`` gives, and a `DeprecationWarning`. docs/renamed.md shows the tables below.
"""

import ast
import importlib
import sys
import warnings
from collections.abc import Iterator, Mapping, Sequence
from importlib.machinery import ModuleSpec
from types import MappingProxyType, ModuleType
from typing import TYPE_CHECKING, Any, cast

import wrapt

if TYPE_CHECKING:
    from importlib.abc import Loader

GONE_IN = "0.3.0"
"""The version in which the old names are gone."""

MODULES: Mapping[str, str] = MappingProxyType(
    {
        "harness.acting": "harness.authoring",
        "harness.attempt": "harness.experiment.checkpoints.attempt",
        "harness.carry": "harness.reward",
        "harness.cell": "harness.record.cell",
        "harness.cell_evaluations": "harness.experiment.evaluation.cell",
        "harness.cell_folder": "harness.record.folder",
        "harness.cell_progress": "harness.experiment.progress.cell",
        "harness.change": "harness.eta.behaviour_change",
        "harness.checkpoint": "harness.experiment.checkpoints.checkpoint",
        "harness.choice": "harness.registry.choice",
        "harness.combination": "harness.results.comparison",
        "harness.curve": "harness.eta.curve",
        "harness.decompose": "harness.eta.splits",
        "harness.episodes": "harness.env.episodes",
        "harness.home": "harness.robot.resting_pose",
        "harness.index": "harness.eta.index",
        "harness.inverse": "harness.robot.inverse_kinematics",
        "harness.kinematics": "harness.robot.kinematics",
        "harness.learning": "harness.results.learning",
        "harness.make": "harness.env.make",
        "harness.manifest": "harness.record.manifest",
        "harness.mean_return": "harness.record.returns",
        "harness.metric": "harness.measure",
        "harness.meshes": "harness.robot.meshes",
        "harness.observation": "harness.env.arm_observation",
        "harness.parameters": "harness.registry.parameters",
        "harness.plan": "harness.experiment.plan",
        "harness.plugins": "harness.registry.registry",
        "harness.random_state": "harness.authoring",
        "harness.recording": "harness.score.csv_steps",
        "harness.rescore": "harness.score.rescore",
        "harness.return_matrix": "harness.results.return_matrix",
        "harness.reward_guess": "harness.score.reward_guess",
        "harness.robot_by_name": "harness.robot.load",
        "harness.run_cell": "harness.experiment.run_cell",
        "harness.score_matrix": "harness.results.score_matrix",
        "harness.score.open_recording": "harness.score.open_steps",
        "harness.seed_mean": "harness.eta.seed_mean",
        "harness.shapes": "harness.robot.shapes",
        "harness.single_env": "harness.env.single_env",
        "harness.solids": "harness.robot.ground_clearance",
        "harness.source_files": "harness.registry.sources",
        "harness.store": "harness.record.store",
        "harness.streams": "harness.env.random_streams",
        "harness.substeps": "harness.authoring",
        "harness.task_form": "harness.experiment.task_form",
        "harness.testing.ideal": "harness.env.ideal",
        "harness.testing.samples": "harness.testing.rewards.samples",
        "harness.testing.simulations": "harness.testing.simulators.simulations",
        "harness.testing.standard_array": "harness.testing.rewards.standard_array",
        "harness.testing.traces": "harness.testing.metrics.traces",
        "harness.trace": "harness.record.trace",
        "harness.trace_parts": "harness.experiment.checkpoints.trace_parts",
        "harness.transfer_evaluation": "harness.transfer.evaluation",
        "harness.transfer_matrix": "harness.transfer.matrix",
        "harness.transfer_record": "harness.transfer.record",
        "harness.urdf": "harness.robot.urdf",
        "harness.watch": "harness.experiment.watch",
        "harness.wrapped_reward": "harness.authoring",
    }
)
"""The module in which the names of each old module stand now, unless `NAMES` or `REPLACED` has them."""

NAMES: Mapping[str, str] = MappingProxyType(
    {
        "harness.audit_dataset": "harness_plugins.audit.audit_dataset",
        "harness.audit_rewards": "harness_plugins.audit.audit_rewards",
        "harness.combination.Combination": "harness.results.comparison.Comparison",
        "harness.decompose.decompose": "harness.eta.decompose.decompose",
        "harness.env.Outcome": "harness.env.decisions.Outcome",
        "harness.environment.Measure": "harness.reward.Given",
        "harness.eta.Comparison": "harness.score.compare.ComparedRuns",
        "harness.eta.compare_recordings": "harness.score.compare.compare_logs",
        "harness.experiment.default_folder": "harness.experiment.experiment.default_folder",
        "harness.experiment.run": "harness.run",
        "harness.inverse.reach_position": "harness.authoring.reach_position",
        "harness.kinematics.Array": "harness.arrays.Float",
        "harness.kinematics.forward": "harness.authoring.forward",
        "harness.kinematics.link_frames": "harness.authoring.link_frames",
        "harness.make.make_env": "harness.make_env",
        "harness.manifest.describe_environment": "harness.experiment.provenance.describe_environment",
        "harness.manifest.describe_machine": "harness.experiment.provenance.describe_machine",
        "harness.manifest.source_commit": "harness.experiment.provenance.source_commit",
        "harness.metric.Metric": "harness.measure.Measure",
        "harness.observation.Observation": "harness.task.Observation",
        "harness.plan.Fit": "harness.experiment.task_plan.Fit",
        "harness.plugins.API_VERSION": "harness.registry.hooks.API_VERSION",
        "harness.plugins.Spec": "harness.registry.spec.Spec",
        "harness.plugins.did_you_mean": "harness.registry.names.did_you_mean",
        "harness.plugins.unknown_name": "harness.registry.names.unknown_name",
        "harness.progress.State": "harness.progress.TrainingState",
        "harness.record.trace.Trace": "harness.log.Log",
        "harness.recording.match_recordings": "harness.score.open_steps.match_steps",
        "harness.recording.open_recording": "harness.score.open_steps.open_steps",
        "harness.robot.read_robot": "harness.robot.robot.read_robot",
        "harness.robot_by_name.load_robot": "harness.load_robot",
        "harness.score.Rows": "harness.reward.row_steps.Rows",
        "harness.score.Scorer": "harness.score.scorer.Scorer",
        "harness.score.compare.compare_recordings": "harness.score.compare.compare_logs",
        "harness.score.open_recording.match_recordings": "harness.score.open_steps.match_steps",
        "harness.score.open_recording.open_recording": "harness.score.open_steps.open_steps",
        "harness.score.scorer.targets_touched": "harness.reward.row_steps.targets_touched",
        "harness.score.targets_touched": "harness.reward.row_steps.targets_touched",
        "harness.shapes.Array": "harness.arrays.Float",
        "harness.testing.algorithms.ALGORITHM_CHECKS": "harness.testing.ALGORITHM_CHECKS",
        "harness.testing.algorithms.check_algorithm": "harness.testing.check_algorithm",
        "harness.testing.ideal.IdealSimulator": "harness.testing.IdealSimulator",
        "harness.testing.metrics.METRIC_CHECKS": "harness.testing.METRIC_CHECKS",
        "harness.testing.metrics.check_metric": "harness.testing.check_metric",
        "harness.testing.rewards.REWARD_CHECKS": "harness.testing.REWARD_CHECKS",
        "harness.testing.rewards.check_reward": "harness.testing.check_reward",
        "harness.testing.simulators.SIMULATOR_CHECKS": "harness.testing.SIMULATOR_CHECKS",
        "harness.testing.simulators.check_simulator": "harness.testing.check_simulator",
        "harness.testing.tasks.TASK_CHECKS": "harness.testing.TASK_CHECKS",
        "harness.testing.tasks.check_task": "harness.testing.check_task",
        "harness.trace.Trace": "harness.log.Log",
        "harness.trace_parts.digest_of": "harness.files.bounded.digest_of",
        "harness.transfer.TransferEvent": "harness.transfer.jobs.TransferEvent",
        "harness.transfer.TransferJob": "harness.transfer.jobs.TransferJob",
        "harness.transfer.TransferPlan": "harness.transfer.jobs.TransferPlan",
        "harness.transfer.plan_transfers": "harness.transfer.jobs.plan_transfers",
        "harness.transfer.run_transfers": "harness.transfer.jobs.run_transfers",
        "harness.transfer.transfer": "harness.transfer.jobs.transfer",
    }
)
"""The new name of each old one whose module is still there, or which stands elsewhere than the rest of its module."""

REPLACED: Mapping[str, str] = MappingProxyType(
    {
        "harness.decompose.no_split": "harness.eta.decompose.decompose",
        "harness.evaluate": "harness.experiment.evaluation.evaluate",
        "harness.evaluation_scalars": "harness.experiment.evaluation.scalars",
        "harness.event_log": "harness.tracker",
        "harness.experiment.run_plan": "harness.run",
        "harness.joint_numbers": "harness.robot.joint_limits",
        "harness.make.build_env": "harness.make_env",
        "harness.manifest.installed_versions": "harness.experiment.provenance.versions_behind",
        "harness.manifest.source_hashes": "harness.registry.sources.source_hash",
        "harness.plain_urdf": "harness.robot.normal_urdf",
        "harness.record.recording.recorded_training.RecordedTraining": "harness.log.Log",
        "harness.recording.Chunk": "harness.log.Rows",
        "harness.recording.Recording": "harness.log.Log",
        "harness.rescore.RecordingScorer": "harness.score.scorer.Payer",
        "harness.robot_file": "harness.robot.settings",
        "harness.score.recording": "harness.log.Log",
        "harness.score.rescore.RecordingScorer": "harness.score.scorer.Payer",
        "harness.score.score_trace": "harness.score.scorer.pay_log",
        "harness.score.scorer.score_trace": "harness.score.scorer.pay_log",
        "harness.scored_runs": "harness.score.installed_reward",
        "harness.shapes.attach_shapes": "harness.robot.Robot.joint_shapes",
        "harness.shapes.read_shapes": "harness.robot.Robot.link_shapes",
        "harness.statistics": "harness.eta.interval",
        "harness.tip": "harness.robot.chain_end",
        "harness.transfer_matrix.Series": "harness.transfer.matrix.Evaluation",
        "harness.transfer_record.read_record": "harness.transfer.record.read_transfer",
        "harness.urdf.carriers": "harness.robot.urdf.Urdf",
        "harness.verdict": "harness.eta.headline",
        "harness.worker": "harness.authoring.run_job",
        "harness.workers": "harness.authoring.run_jobs",
    }
)
"""What takes the place of each old name that does not work, because the new one is used in another way."""


def find_old_names() -> None:
    """Make Python find the old names: modules that are gone, and names that are gone from modules that are there."""
    if not any(isinstance(finder, _OldModules) for finder in sys.meta_path):
        sys.meta_path.append(_OldModules())  # the last: what there is comes first
    for module in {name.rpartition(".")[0] for name in [*NAMES, *REPLACED]} - MODULES.keys() - {"harness"}:
        wrapt.when_imported(module)(_give_old_names)


def new_name(old: str) -> str | None:
    """The present name of one that still works, ``harness.record.cell.Cell`` of ``harness.cell.Cell``; None of others.

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


def found_at(new: str) -> Any:
    """What a present dotted name stands for, ``harness.run``; its module is imported."""
    place, _, name = new.rpartition(".")
    return getattr(importlib.import_module(place), name)


def warn_of(old: str, instead: str) -> None:
    """Warn of an old name, at the line that used it: the line that called who calls this.

    Args:
        old: The name that was used.
        instead: What to write.
    """
    warnings.warn(_moved(old, instead), DeprecationWarning, stacklevel=3)


def old_names_in(source: str) -> list[str]:
    """A line for each old name that a Python source imports.

    Raises:
        SyntaxError: It is no Python.
    """
    found = [old for node in ast.walk(ast.parse(source)) for old in _imported(node)]
    return [told for old in dict.fromkeys(found) if (told := why_gone(old) or _if_moved(old))]


def _if_moved(old: str) -> str:
    new = new_name(old)
    return "" if new is None else _moved(old, _import_of(new))


def _moved(old: str, instead: str) -> str:
    return f"{old} moved: {instead} (the old name goes with {GONE_IN})"


def _import_of(new: str) -> str:
    module, _, name = new.rpartition(".")
    return f"import {new}" if new in MODULES.values() else f"from {module} import {name}"


def _imported(node: ast.AST) -> Iterator[str]:
    """The dotted names that a statement imports."""
    if isinstance(node, ast.Import):
        yield from (it.name for it in node.names)
    elif isinstance(node, ast.ImportFrom) and not node.level:
        yield from (f"{node.module}.{it.name}" for it in node.names)


class _OldModules:
    """Finds the modules that are gone: empty ones, which look their names up where these stand now.

    It is a finder and a loader without their base classes, whose module takes 5 ms of every start.
    """

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> ModuleSpec | None:
        if gone := why_gone(name):
            raise ModuleNotFoundError(gone, name=name)
        if name not in MODULES:
            return None
        return ModuleSpec(name, cast("Loader", self), origin=MODULES[name])

    def create_module(self, spec: ModuleSpec) -> ModuleType | None:
        return None  # Python makes it

    def exec_module(self, module: ModuleType) -> None:
        _give_old_names(module)


def _give_old_names(module: ModuleType) -> None:
    def look_up(name: str) -> Any:
        old = f"{module.__name__}.{name}"
        if gone := why_gone(old):
            raise ImportError(gone, name=module.__name__)
        new = None if name.startswith("__") else new_name(old)
        if new is None:
            raise AttributeError(f"module '{module.__name__}' has no attribute '{name}'")
        found = found_at(new)
        warn_of(old, _import_of(new))
        return found

    vars(module)["__getattr__"] = look_up
