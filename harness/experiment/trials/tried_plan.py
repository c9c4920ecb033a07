"""A plan after its rewards, measures and environments were tried: what cannot work is refused, or left out and told."""

import faulthandler
import json
import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar

from harness.errors import HarnessError, UsageError, one_line
from harness.executor import Limits
from harness.experiment.plan import Plan
from harness.experiment.run_cell import world_of
from harness.experiment.task_plan import table_of
from harness.experiment.trials.tried import Fault, Tried, fault_of
from harness.experiment.workers.order import Order, Report
from harness.experiment.workers.workers import News, Offspring, Pool
from harness.files.plain import Plain
from harness.record.cell import Cell
from harness.record.folder import LOG, partial_folder, publish
from harness.registry.choice import Choice, Registry
from harness.registry.given import Given, PluginFile
from harness.registry.registry import load_registry

CALL_SECONDS, ENV_SECONDS, ALL_SECONDS = 60.0, 120.0, 300.0
"""How long one call of a reward, what an env does by itself, and a whole trial may take."""
LIMITS = Limits(cell_time=ALL_SECONDS)
MOST_LOST = 5
"""After so many processes that did not survive a reward, no other is started."""
ANSWER, TIMEOUT = "tried.json", "Timeout ("
"""The file with the answer, and what begins the stack that `faulthandler` writes when a call takes too long."""


@dataclass(frozen=True)
class TryTask(Plain):
    """The trial of one task, as a worker is told to do it.

    Attributes:
        cell: Whose task, or environment.
        rewards: Those of an arm that are tried; in an environment all are.
        plugins: What was given by hand.
        notes: Path of a file that names the column that is asked.
        without: Columns that are not asked.
    """

    cell: Cell
    rewards: tuple[Choice, ...]
    plugins: tuple[Given, ...]
    notes: str = ""
    without: tuple[str, ...] = ()

    noun: ClassVar[str] = "trial"

    def do(self, folder: Path, report: Report) -> bool:
        with Path(self.notes).open("wb", buffering=0) as notes:

            def tell(column: str) -> None:
                notes.seek(0)
                notes.write(column.encode() + b"\n")
                faulthandler.dump_traceback_later(CALL_SECONDS if column else ENV_SECONDS, exit=True)

            try:
                world = world_of(self.cell, load_registry(given=self.plugins), folder, report)
                tried = world.try_out(self.rewards, self.without, tell)
            except HarnessError as error:
                tried = Tried((), (one_line(error),))
            finally:
                faulthandler.cancel_dump_traceback_later()
        (partial_folder(folder) / ANSWER).write_text(json.dumps(tried.to_json()), encoding="utf-8")
        publish(partial_folder(folder), folder, is_lasting=False)
        return True


def try_tasks(works: Sequence[TryTask]) -> list[Tried]:
    """The trials of tasks, one after the other. When it returns, none of their processes and files are left."""
    offspring = Offspring()
    with (
        tempfile.TemporaryDirectory(prefix="harness-trial-", ignore_cleanup_errors=True) as folder,
        Pool(offspring.environment) as pool,
        offspring.ended_at_once(),
    ):
        return [_try(work, Path(folder) / str(number), pool, offspring) for number, work in enumerate(works)]


def _try(work: TryTask, folder: Path, pool: Pool, offspring: Offspring) -> Tried:
    """One trial; without each reward that a process did not survive, it is begun again."""
    lost: list[Fault] = []
    notes = folder.with_suffix(".notes")
    for number in range(1 + MOST_LOST):
        answer = folder.with_name(f"{folder.name}-{number}")
        without = tuple(fault.column for fault in lost)
        *_, news = pool.run([Order(answer, replace(work, notes=str(notes), without=without), LIMITS)], at_once=1)
        if not news.reason:
            tried = Tried.from_json(json.loads((answer / ANSWER).read_text(encoding="utf-8")))
            return replace(tried, faults=(*lost, *tried.faults))
        offspring.kill()
        reason = _why_lost(news, partial_folder(answer) / LOG)
        column = notes.read_text(encoding="utf-8").partition("\n")[0] if notes.exists() else ""
        if not column:
            return Tried(tuple(lost), (f"{work.cell.task.label}: its trial failed, {reason}",))
        lost.append(fault_of(column, reason, is_lost=True))
    return Tried(tuple(lost))


def _why_lost(news: News, log: Path) -> str:
    text = log.read_text(encoding="utf-8", errors="replace") if log.is_file() else ""
    if TIMEOUT in text or news.over_limit:
        return f"has not returned after {CALL_SECONDS:g} s."
    return f"ends the process: {news.reason}."


TRIED = "tried in an episode of random actions"


def try_plan(plan: Plan, registry: Registry) -> tuple[Plan, Registry]:
    """Try each task of a plan for an episode: see `harness.experiment.trials`.

    Where one of several rewards is chosen, and where a pattern such as ``rewards/*.py`` found the file, a reward that
    fails is left out; its cells are skipped with the reason. Anything else that fails is refused. So is a measure,
    because it decides.

    Args:
        plan: The plan.
        registry: The plugins.

    Returns:
        The plan without what is left out, and the registry without it.

    Raises:
        UsageError: Something fails, or nothing is left to compare.
    """
    works = [TryTask(cell, rewards, registry.given) for cell, rewards in _to_try(plan.cells, registry)]
    tried = try_tasks(works) if works else []
    faults: dict[tuple[Choice, str, str], Fault] = {
        (work.cell.task, fault.noun, fault.name): fault
        for work, it in zip(works, tried, strict=True)
        for fault in it.faults
    }
    notes = dict.fromkeys(note for it in tried for note in it.notes)
    for (task, _, _), fault in faults.items():
        _require_spared(task, fault, plan, registry)
    skipped = [
        (cell, faults[key].sentence) for cell in plan.cells if (key := (cell.task, "reward", _tried_as(cell))) in faults
    ]
    gone = {cell for cell, _ in skipped}
    cells = tuple(cell for cell in plan.cells if cell not in gone)
    if gone and len({cell.reward for cell in cells}) < 2 and not plan.control:
        told = " ".join(dict.fromkeys(reason for _, reason in skipped))
        raise UsageError(f"Nothing is left to compare, {TRIED}: {told} Nothing was trained: mend them")
    left_out = dict.fromkeys(f"Left out, {TRIED}: {fault.sentence}" for fault in faults.values())
    untrained = {cell.reward for cell in gone} - {cell.reward for cell in cells}
    registry = _without(registry, {fault.name for fault in faults.values()})
    plan = replace(
        plan,
        cells=cells,
        skipped=(*plan.skipped, *skipped),
        resolved=_without_rewards(plan.resolved, untrained, registry),
        warnings=(*plan.warnings, *left_out, *notes),
    )
    return plan, registry


def _tried_as(cell: Cell) -> str:
    """What the trial calls the reward of a cell: in an environment without the weights of its terms."""
    return cell.reward.label if "rewards" in cell.plugins else cell.reward.name


def _to_try(cells: Sequence[Cell], registry: Registry) -> list[tuple[Cell, tuple[Choice, ...]]]:
    """A cell of each task, with the rewards to try there; an arm's rewards of our own need no trial."""
    found: dict[tuple[Choice, str], dict[Choice, Cell]] = {}
    for cell in cells:
        found.setdefault((cell.task, cell.robot), {}).setdefault(cell.reward, cell)
    return [
        (next(iter(of.values())), tuple(of))
        for of in found.values()
        if registry.given
        or any(
            "rewards" not in cell.plugins or not registry.is_built_in("rewards", cell.reward.name)
            for cell in of.values()
        )
    ]


def _require_spared(task: Choice, fault: Fault, plan: Plan, registry: Registry) -> None:
    """Raise UsageError unless everything goes on without what failed."""
    file = _file_of(fault, registry)
    may_lack = bool(plan.terms.budget) or (file is not None and file.optional)
    baseline = {plan.baseline, *(_tried_as(cell) for cell in plan.cells if cell.reward.label == plan.baseline)}
    is_spared = may_lack and fault.noun == "reward" and fault.name not in baseline
    if not is_spared:
        where = f" ('{file.path}')" if file else ""
        raise UsageError(
            f"{task.label}, {TRIED}: {fault.noun} '{fault.name}'{where} {fault.reason} "
            "Nothing was trained: mend it, or leave it out"
        )


def _file_of(fault: Fault, registry: Registry) -> PluginFile | None:
    """The file that was given by hand in which it stands."""
    function = registry.functions_of(fault.noun).get(fault.name)
    if function is not None:
        return function.file
    files: Mapping[str, PluginFile] = {it.name: it for it in registry.given if isinstance(it, PluginFile)}
    name = fault.name.partition(":")[0]
    specs = registry.specs.get(("rewards", name), []) if fault.noun == "reward" else []
    return next((files[spec.plugin] for spec in specs if spec.plugin in files), None)


def _without_rewards(resolved: Mapping[str, Any], gone: set[Choice], registry: Registry) -> dict[str, Any]:
    """The keys of the experiment file without rewards that no cell trains, and without files that are left out."""
    told = [*(table_of(reward) for reward in gone), *(reward.label for reward in gone)]
    given = {it.name for it in registry.given}
    plugins = [need for need in resolved.get("plugins", []) if Path(need.get("path") or need["target"]).name in given]
    kept = {"reward": [reward for reward in resolved["reward"] if reward not in told], "plugins": plugins}
    return {key: kept.get(key, value) for key, value in resolved.items()}


def _without(registry: Registry, names: set[str]) -> Registry:
    """The registry without functions that failed: no recording asks them."""
    failed = [it for it in registry.functions if it.name in names and it.noun == "reward"]
    if not failed:
        return registry
    files = {it.file: tuple(one.name for one in failed if one.file == it.file) for it in failed}
    gone = {file for file in files if all(it in failed for it in registry.functions if it.file == file)}
    given = [
        replace(it, left_out=files[it]) if isinstance(it, PluginFile) and it in files else it
        for it in registry.given
        if it not in gone
    ]
    return load_registry(given=given)
