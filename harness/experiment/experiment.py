"""Run an experiment: from what a user asks for to the results."""

import math
import time
import warnings
from collections.abc import Callable, Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, fields, replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any, Unpack

from harness.errors import UsageError
from harness.executor import Event, Executor, Job, OnEvent, Tracker
from harness.experiment.changed import Sources, changed_cells, refuse_changed
from harness.experiment.followed import EndedCells, Followed, OnTrouble, Trackers, Tracking, build_trackers
from harness.experiment.looks import refuse_other_looks
from harness.experiment.objects import name_objects
from harness.experiment.plan import Experiment, Plan, check_experiment, expand
from harness.experiment.run_options import DEFAULTS, RunArguments, RunOptions
from harness.experiment.trials.tried_plan import try_plan
from harness.record.cell import Cell, Manifest, read_left, read_manifest
from harness.record.earlier import ALGORITHMS
from harness.record.out_folder import storage_errors
from harness.record.plan_file import refuse_mixed
from harness.record.store import Store, floors_in
from harness.registry.allowed import allow_typed
from harness.registry.choice import Choice, Registry, split_list
from harness.registry.given import Given as Plugins, read_given, require_given, split_measures
from harness.registry.registry import load_registry
from harness.results import Results
from harness.results.load import load_results
from harness.results.results import standing_of
from harness.text import visible

DEFAULT_FOLDER = Path("results") / "runs"


def _warn(line: str) -> None:
    warnings.warn(visible(line), RuntimeWarning, stacklevel=2)


def run(**given: Unpack[RunArguments]) -> Results:
    """Run every combination of an experiment that is not done yet.

    Args:
        **given: The fields of `RunOptions`, such as ``out`` and ``jobs``, and those of
            `harness.experiment.plan.Experiment`, such as ``sim`` and ``algo``; its lists may be single names, or text
            with commas. Where a name is expected, an object may stand whose class workers can import. ``plugins``
            lists files and classes beside the installed plugins; see `harness.registry.given.read_given`. ``measure``
            lists names of measures, and files whose functions measure what the agent does.

    Raises:
        UsageError: Something given cannot be used; nothing is written.
    """
    of_options = {field.name for field in fields(RunOptions)}
    everything, classes = name_objects(given)
    allow_typed(_texts_of(everything.get("task")))
    names, files = split_measures(everything.pop("measure", ()))
    plugins = dict.fromkeys([*read_given(everything.pop("plugins", ()), files), *classes])
    everything |= {"measure": names} if names else {}
    options = {name: everything.pop(name) for name in tuple(everything) if name in of_options}
    return prepare(check_experiment(everything), RunOptions(**options), tuple(plugins)).run()


def _texts_of(task: Any) -> list[str]:
    """The ids that a program names, as they are typed: what it says is its user's word."""
    items = task if isinstance(task, list | tuple) else [task]
    ids = [f"id={item['id']}" for item in items if isinstance(item, Mapping) and "id" in item]
    return [*(item for item in items if isinstance(item, str)), *ids]


@dataclass(frozen=True)
class ExperimentRun:
    """An experiment that is ready to run: everything is checked, and nothing is written but its folder.

    Attributes:
        plan: What to do.
        store: Where.
        registry: The plugins.
        executor: What runs the cells.
        options: How.
        trackers: What shows them elsewhere, by label.
    """

    plan: Plan
    store: Store
    registry: Registry
    executor: Executor
    options: RunOptions = DEFAULTS
    trackers: Mapping[str, Tracker] = field(default_factory=dict)

    def run(self, on_event: OnEvent = lambda event: None) -> Results:
        """Do the cells that are not done yet; see `begin` and `BegunRun.run`."""
        with self.begin() as begun:
            return begun.run(on_event)

    @contextmanager
    def begin(self, on_wait: Callable[[], None] = lambda: None) -> Iterator["BegunRun"]:
        """Keep other runs out of the folder, and write down what is asked for.

        Args:
            on_wait: Called before this waits for another run in the folder to end, if the options say to wait.

        Raises:
            UsageError: Another run is using the folder, and the options say not to wait; or cells in it were done by
                other plugins, and the options say neither to keep them nor to do them again. Nothing is written.
            StorageError: The folder cannot be written, now or while the cells run.
        """
        with storage_errors(self.store.folder), self.store.locked(on_wait if self.options.wait else None):
            begun = self.look()
            self.store.add(self.plan)
            yield begun

    def look(self) -> "BegunRun":
        """What is done, and what will be run. Writes nothing; another run may be changing it.

        Raises:
            UsageError: Cells were done by other plugins, and the options say neither to keep them nor to do them again.
        """
        manifests = map(self.store.examine, self.plan.cells)
        done = {it.cell: it.environment.get("sources", {}) for it in manifests if it.status == "done"}
        again = self._to_do_again(done)
        return BegunRun(self, tuple(cell for cell in done if cell not in again), again)

    def _to_do_again(self, done: Mapping[Cell, Sources]) -> dict[Cell, Manifest]:
        """Done cells that other plugins made, if the options say that such cells are done again."""
        if self.options.changed == "keep":
            return {}
        changed = changed_cells(done, self.registry)
        if self.options.changed == "refuse":
            refuse_changed(changed)
        return {cell: read_manifest(self.store.cell_folder(cell)) for cell in changed}


@dataclass(frozen=True)
class BegunRun:
    """A run that has locked its experiment's folder.

    Attributes:
        asked: What is to be run.
        done: Cells that were done before, and are not run again.
        again: Those that are, with what there is to say of them; each is replaced as it ends.
    """

    asked: ExperimentRun
    done: tuple[Cell, ...]
    again: Mapping[Cell, Manifest] = field(default_factory=dict)

    @property
    def waiting(self) -> tuple[Cell, ...]:
        """The cells that will be run: those that are not done, as far as `only` and `limit` allow."""
        done = set(self.done)
        return tuple(cell for cell in self._selected if cell not in done)[: self.asked.options.limit]

    @property
    def foreseen(self) -> tuple[Cell, ...]:
        """The first of them, as many as may be run: choosing one of several rewards does not need all of them."""
        budget = self.asked.plan.terms.budget
        return self.waiting[: max(budget - len(self.done), 0)] if budget else self.waiting

    @property
    def spared(self) -> tuple[Cell, ...]:
        """The cells that are asked for by name, and were done before."""
        selected = set(self._selected)
        return tuple(cell for cell in self.done if cell in selected)

    @property
    def _selected(self) -> tuple[Cell, ...]:
        plan, only = self.asked.plan, self.asked.options.only
        return plan.cells if only is None else select(plan.cells, only, self.asked.registry.short_names("algorithms"))

    def run(self, on_event: OnEvent = lambda event: None, on_trouble: OnTrouble = _warn) -> Results:
        """Do the cells that wait; those that fail as often again as the options say.

        Args:
            on_event: Told what happens to the cells.
            on_trouble: Told when a tracker is switched off, and why.

        Returns:
            What the experiment's folder says afterwards, earlier cells included.
        """
        store, options, waiting = self.asked.store, self.asked.options, self.waiting
        # What else was begun stays too: run_cell says what becomes of it.
        store.discard_partial(keep={store.reopen(cell) for cell in waiting})
        ended = EndedCells(store, self.asked.registry, options.metrics)
        trackers = Trackers(self.asked.trackers, on_trouble)
        tracking = Tracking(trackers, store.folder, read_left(store.folder))
        followed = Followed(store, ended, tracking, on_event, self.again)
        until = time.monotonic() + options.budget if options.budget else math.inf
        try:
            for stage in self._stages():
                waiting = stage
                for _ in range(1 + options.retry_failed):
                    followed.failed.clear()
                    self._do(waiting, followed, until)
                    waiting = tuple(followed.failed)
                if time.monotonic() >= until or (options.fail_fast and followed.failed):
                    break
        finally:
            followed.stop()
            store.discard_partial()
            ended.write()
        return load_results(store.folder, options.curve, options.metrics, registry=self.asked.registry)

    def _stages(self) -> Iterator[tuple[Cell, ...]]:
        """The cells that wait: all at once, or those that an answer waits for, one stage after the other."""
        terms, tried, options = self.asked.plan.terms, set[Cell](), self.asked.options
        if not terms.has_plan:
            yield self.waiting
            return
        may = set(self._selected)
        while True:
            results = load_results(self.asked.store.folder, metrics=options.metrics, registry=self.asked.registry)
            standing = standing_of(results)
            wanted = [] if standing is None else standing.next
            done = {it.cell for it in results.done}
            cells = tuple(cell for cell in wanted if cell in may and cell not in done and cell not in tried)
            if options.limit is not None:
                cells = cells[: options.limit - len(tried)]
            if not cells:
                return
            tried |= set(cells)
            yield cells

    def _do(self, cells: Sequence[Cell], followed: Followed, until: float) -> None:
        """Have the executor do cells, until a time; with the option `fail_fast`, until one fails."""
        store, options = self.asked.store, self.asked.options
        carriers = floor_carriers(cells, store)
        of_all = replace(options.of_cells, plugins=self.asked.registry.given)
        jobs = [
            Job(cell, store.cell_folder(cell).absolute(), replace(of_all, floor=cell in carriers)) for cell in cells
        ]

        def follow(event: Event) -> None:
            followed(event)
            is_late = event.kind == "ended" and time.monotonic() >= until
            if is_late or (options.fail_fast and followed.failed):
                raise _Enough

        with suppress(_Enough):
            self.asked.executor.run(jobs, options.at_once, follow)


class _Enough(Exception):
    """Raised when no other cell is to be done: one has failed, or the time is over."""


def prepare(experiment: Experiment, options: RunOptions = DEFAULTS, given: Sequence[Plugins] = ()) -> ExperimentRun:
    """Check everything that an experiment needs, then make its folder, or look whether it can go on with one.

    Args:
        experiment: What to do.
        options: How.
        given: Plugins beside the installed ones.

    Raises:
        UsageError: Something given cannot be used; nothing is written.
    """
    ready = check(experiment, options, given)
    Store.claim(ready.store.folder)
    return ready


def check(experiment: Experiment, options: RunOptions = DEFAULTS, given: Sequence[Plugins] = ()) -> ExperimentRun:
    """Check everything that an experiment needs. Writes nothing; see `prepare`.

    Raises:
        UsageError: Something given cannot be used, or fails in an episode of random actions.
    """
    require_given(experiment.plugins, given)
    registry = load_registry(given=given)
    executor, trackers = options.build_executor(registry), build_trackers(options.tracker, registry)
    plan = expand(experiment, registry, partial(_begun_with, options))
    if not plan.cells:
        reasons = dict.fromkeys(reason for _, reason in plan.skipped)
        raise UsageError(f"Nothing can be run: {'; '.join(reasons)}")
    if options.metrics is not None:
        plan.require_metrics([options.metrics] if isinstance(options.metrics, str) else options.metrics)
    if options.only is not None:
        select(plan.cells, options.only, registry.short_names("algorithms"))
    store = _store_of(options, plan)
    if Store.is_experiment(store.folder):
        asked = (*plan.cells, *(cell for cell, _ in plan.skipped))
        earlier = store.read_plan()
        refuse_mixed(f"--out '{store.folder}'", earlier.cells, asked)
        replace(earlier, cells=asked).with_cells_of(earlier.cells)  # refuses what would be too many
        new = [cell for cell in earlier.cells if cell.reward.label == plan.baseline]
        is_open = bool(plan.terms.seconds) and all(store.examine(cell).status == "pending" for cell in new)
        refuse_other_looks(store.folder, earlier, plan.terms, asked, is_open=is_open)
        plan = replace(plan, warnings=(*plan.warnings, *_renamed_since(earlier.cells, plan.cells, registry)))
    if any(store.examine(cell).status != "done" for cell in plan.cells):
        plan, registry = try_plan(plan, registry)
    return ExperimentRun(plan, store, registry, executor, options, trackers)


def _renamed_since(earlier: Sequence[Cell], planned: Sequence[Cell], registry: Registry) -> Iterator[str]:
    """A line for each algorithm of earlier cells whose name means one of the plan's now."""
    algorithms, meant = {it.algorithm.name for it in planned}, registry.short_names("algorithms")
    for old in sorted({it.algorithm.name for it in earlier} & ALGORITHMS.keys()):
        if meant.get(old) in algorithms:
            yield (
                f"until 0.2 '{old}' was the algorithm that is called {ALGORITHMS[old]} now; since 0.3 it is short for "
                f"{meant[old]}. The folder's cells of {old} stay, and {meant[old]} is trained beside them"
            )


def _store_of(options: RunOptions, plan: Plan) -> Store:
    return Store.at(Path(options.out) if options.out else default_folder(plan))


def _begun_with(options: RunOptions, plan: Plan) -> frozenset[Choice]:
    """The algorithms of the experiment that a plan's folder holds; see `harness.experiment.plan.Begun`."""
    store = _store_of(options, plan)
    cells = store.read_plan().cells if Store.is_experiment(store.folder) else ()
    return frozenset(cell.algorithm for cell in cells)


def default_folder(plan: Plan) -> Path:
    """A folder named for what the plan does: the same plan finds its results again."""
    first = plan.cells[0] if plan.cells else plan.skipped[0][0]
    names = f"{first.place.name}-{first.algorithm.name}".replace("/", "-")  # of a qualified name
    return DEFAULT_FOLDER / f"{names}-{plan.id}"


def floor_carriers(waiting: Sequence[Cell], store: Store) -> frozenset[Cell]:
    """The first of the waiting cells of each floor that no done cell in the folder has.

    Args:
        waiting: Cells that are going to be done, in order.
        store: The experiment's folder.
    """
    stay = [manifest for manifest in store.manifests() if manifest.cell not in set(waiting)]  # others are replaced
    there, carriers = floors_in(stay, store), dict[Hashable, Cell]()
    for cell in waiting:
        if cell.floor not in there:
            carriers.setdefault(cell.floor, cell)
    return frozenset(carriers.values())


KINDS = ("simulator", "algorithm", "reward", "seed", "cell")


def select(cells: Sequence[Cell], text: str, short: Mapping[str, str] = MappingProxyType({})) -> tuple[Cell, ...]:
    """The cells that `text` names.

    Each word is the name or label of a simulator, algorithm or reward, ``seed=3``, or the id of a cell. Words of one
    kind are alternatives; words of several kinds all have to hold: ``sac,ppo,seed=0`` is seed 0 of both algorithms.

    Args:
        cells: To choose from.
        text: The words.
        short: What is short for an algorithm, and its name.

    Raises:
        UsageError: A word names nothing in these cells.
    """
    asked: dict[str, set[str]] = {}
    for given in split_list(text):
        name, colon, params = given.partition(":")
        word = f"{short.get(name, name)}{colon}{params}"
        kinds = [kind for kind in KINDS if any(word in _names(cell)[kind] for cell in cells)]
        if not kinds:
            raise UsageError(f"--only: no cell of this experiment has '{word}'. Allowed are {_offer(cells)}")
        asked.setdefault(kinds[0], set()).add(word)
    return tuple(cell for cell in cells if all(words & set(_names(cell)[kind]) for kind, words in asked.items()))


def _names(cell: Cell) -> Mapping[str, Sequence[str]]:
    """The words that name a cell, by kind."""
    choices = {"simulator": cell.place, "algorithm": cell.algorithm, "reward": cell.reward}
    named = {kind: (choice.label, choice.name) for kind, choice in choices.items()}
    return {**named, "seed": (f"seed={cell.seed}",), "cell": (cell.id,)}


def _offer(cells: Iterable[Cell]) -> str:
    """The words that are possible, without the ids of cells."""
    found: dict[str, dict[str, None]] = {kind: {} for kind in KINDS[:-1]}
    for cell in cells:
        for kind, names in found.items():
            names[_names(cell)[kind][0]] = None
    return ", ".join(name for names in found.values() for name in names)
