"""What follows from the files of done cells of arms, each thing computed once; see `harness.results.kept`."""

import hashlib
import math
from collections import defaultdict
from collections.abc import Callable, Collection, Hashable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import cache, cached_property, partial
from typing import Any, Self, TypeVar

import numpy as np

from harness.arrays import Float
from harness.errors import Unmeasured, Unscored, one_line
from harness.eta.headline import SUCCESS
from harness.eta.manner import OWN_AND_OTHER, TRAINING
from harness.log import Log
from harness.log.log import episode_sums
from harness.log.measure import Measure
from harness.record.cell import Cell, Manifest
from harness.record.folder import EVALUATION, EVALUATIONS, RANDOM, SUFFIX, TRACE, evaluation_files, parts_of
from harness.record.plan_file import StoredPlan
from harness.record.store import Store
from harness.record.trace import (
    EVENTS,
    PAID,
    episode_facts,
    mean_over_episodes,
    mean_return,
    paid_in,
    read_trace,
    terms_of,
    with_episode_facts,
)
from harness.registry.choice import Choice, Registry
from harness.registry.sources import fingerprint
from harness.results.by_term import ByTerm, by_term, part_of
from harness.results.comparison import Group
from harness.results.kept import Kept
from harness.results.metrics import Unmeasurable, Values, load_metrics, value_of
from harness.results.recordings.episodes import Did, Episodes, Part
from harness.results.table import RANDOM as AT_RANDOM, Numbers
from harness.reward import Paid
from harness.score.installed_reward import InstalledReward

SLACK = 100_000
"""Rows that a trace may have beyond its training's budget, as the last decision of many envs may; and the steps that an
episode of an evaluation may have, where the training was shorter than that."""
START, END = "start ", "end "
"""The first and the last episodes of a training, see `harness.results.by_term.part_of`."""
SUMMED = {"return": ("reward",), "events": EVENTS, "paid": PAID}
"""What is summed over an episode."""
Told = TypeVar("Told")
FILES = {"training": TRACE, "evaluation": EVALUATION}


class Cells:
    """The done cells of arms, and the rewards and metrics that are asked about them.

    Attributes:
        store: Their folder.
        metrics: Every registered metric, or those that were chosen, by name.
        done: What was taken in, by id.
        installed: What pays recorded runs again, by a reward.
    """

    def __init__(
        self, store: Store, registry: Registry, plan: StoredPlan, metrics: Iterable[str] | None = None,
        named: Sequence[str] = (),
    ) -> None:  # fmt: skip
        """Take in no cell yet.

        Args:
            store: The folder of the experiment.
            registry: The plugins, for metrics and rewards.
            plan: What is compared.
            metrics: Which metrics; see `harness.results.metrics.load_metrics`.
            named: The measures that the experiment names; see there.

        Raises:
            UsageError: A named metric is not registered.
            PluginError: A named metric is broken.
        """
        self.store, self._plan = store, plan
        self.metrics = load_metrics(registry, metrics, named)
        self.done: dict[str, CellResults] = {}
        self.installed = cache(partial(InstalledReward, registry=registry))
        self._floors: dict[Hashable, CellResults] | None = None

    @cached_property
    def scoring(self) -> tuple[Choice, ...]:
        """The rewards that evaluations are paid by, and random actions."""
        return tuple(dict.fromkeys(cell.reward for cell in self._plan.cells))

    def compared_with(self, cell: Cell) -> list[Choice]:
        """The rewards to compare with: the others for the baseline, the baseline for others, itself for a control."""
        baseline, rewards = self._plan.baseline, self._rewards[Group.of(cell)]
        asked = (it for it in rewards if it != cell.reward or self._plan.control)
        return [it for it in asked if baseline in (it.label, cell.reward.label)]

    @cached_property
    def _rewards(self) -> Mapping[Group, Collection[Choice]]:
        found = defaultdict[Group, dict[Choice, None]](dict)
        for cell in self._plan.cells:
            found[Group.of(cell)][cell.reward] = None
        return found

    @cached_property
    def fingerprinted(self) -> dict[str, tuple[Measure, str]]:
        """The metrics, each with its fingerprint. One whose sources cannot be read becomes `Unmeasurable`."""
        found = dict[str, tuple[Measure, str]]()
        for name, metric in self.metrics.items():
            try:
                found[name] = metric, fingerprint(metric)
            except Exception as error:  # a plugin may be of any make
                instead = Unmeasurable(f"its sources cannot be read: {one_line(error)}")
                found[name] = instead, fingerprint(instead)
        return found

    def add(self, done: Manifest) -> "CellResults":
        """Take in a done cell; one that was trained again takes its own place."""
        found = self.done.get(done.cell.id)
        if found is None or found.manifest != done:
            found = self.done[done.cell.id] = CellResults(self, done)
            self._floors = None
        return found

    def remove(self, cell: Cell) -> None:
        """Leave out a cell, if it was taken in."""
        self.done.pop(cell.id, None)
        self._floors = None

    def at_random(self, cell: Cell) -> "CellResults | None":
        """What evaluated random actions in the simulator, task and robot of a cell; None if no cell did."""
        if self._floors is None:  # of several, the first that was taken in
            self._floors = {it.cell.floor: it for it in reversed(self.done.values()) if it.has_floor}
        return self._floors.get(cell.floor)


class CellResults(Did):
    """A done cell of an arm as a training. Its pay is asked as that of a `harness.results.recordings.runs.Run`.

    Every method raises SchemaError if a file that it has to read is damaged, or written by a newer version. In a `with`
    block, columns that one method has read are kept for the others.

    Attributes:
        manifest: What the cell says of itself. Only files that it names are read.
    """

    def __init__(self, cells: Cells, done: Manifest) -> None:
        """Read nothing yet but what is kept."""
        self.cell, self.manifest, self._cells = done.cell, done, cells
        self.seed, self.reward = done.cell.seed, done.cell.reward.label
        self._files = cells.store.cell_folder(done.cell)
        self._kept = Kept(cells.store.folder, done.cell.id, self._files, done.files)
        self._read: dict[str, Log] = {}
        self._asking = 0
        self.reasons: dict[str, str] = {}
        self._measure, self._digests = cache(self._measured), cache(self._digests_now)

    def __enter__(self) -> Self:
        self._asking += 1
        return self

    def __exit__(self, *_: object) -> None:
        """Keep the numbers and drop the traces, because a report asks for one cell after the other."""
        self._asking -= 1
        if not self._asking:
            self._read.clear()
            self._kept.save()

    def keep(self) -> None:
        """Compute what a report will ask of each trace of which nothing is kept yet, one after the other, and keep it.

        Raises:
            SchemaError: A file of the cell is damaged, or one that the cell cannot have left.
        """
        others = (f"{EVALUATIONS}/{path.name}" for path in evaluation_files(self._files).values())
        other = f"{OWN_AND_OTHER[self.cell.deterministic][1]}{SUFFIX}"
        with self:
            for file in filter(self._is_there, (*others, EVALUATION, other, RANDOM, TRACE)):
                self._ask(file, "is kept", partial(self._keep, file))
                self._read.clear()

    def _keep(self, file: str, trace: Log) -> bool:
        """Compute what a report asks of a trace."""
        _ = self._measure(file), self._count(file), self.recorded_return("return", file)
        own, *payers = map(self._cells.installed, (self.cell.reward, *self._cells.scoring))
        paying: list[Callable[[], object]] = []
        if file == TRACE:
            _ = self.cut, self.recorded, self.has_terms, None if self.cell.evaluate_every else self.episodes
            others = map(self._cells.installed, self._cells.compared_with(self.cell))
            paying = [partial(self.terms_paid, own, TRACE), *(partial(self.paid_by, it) for it in others)]
        elif file == EVALUATION:
            _ = self.longest, self.motion, self.recorded_return("events"), self.recorded_return("paid")
            paying = [partial(self.evaluation_return, it) for it in payers]
        elif file == RANDOM:
            paying = [partial(self.floor_returns, it) for it in payers]
        if file in FILES.values():
            paying.append(partial(self.unchanged, file))
        if file in {EVALUATION, RANDOM}:
            paying += [partial(self.terms_paid, it, file) for it in (own, *payers) if it.has_terms]
        for pay in paying:
            with suppress(Unscored):  # the report says so
                pay()
        return True

    # What was measured

    @cached_property
    def _manners(self) -> Mapping[str, Part]:
        """Every metric of the policy in both manners, and of the training."""
        own, other = OWN_AND_OTHER[self.cell.deterministic]
        files = {own: EVALUATION, other: f"{other}{SUFFIX}", TRAINING: TRACE}
        with self:
            return {
                manner: Part(self._count(file), {}, self._measure(file), self.reasons)
                for manner, file in files.items()
                if manner != other or self._is_there(file)
            }

    @property
    def _floor(self) -> Values:
        owner = self.floor_cell  # it may end later
        return owner._measure(RANDOM) if owner else dict.fromkeys(self._cells.metrics)

    @property
    def numbers(self) -> Numbers:
        """What a table of cells says of it, in the columns of `harness.results.table.metric_columns`."""
        told = self.measured
        at_random = {f"{AT_RANDOM}{name}": value for name, value in told.random.items()}
        return Numbers({**told.own, **at_random}, told.reasons)

    @property
    def has_floor(self) -> bool:
        """Whether the cell evaluated random actions."""
        return self._is_there(RANDOM)

    @property
    def floor_cell(self) -> "CellResults | None":
        """What evaluated random actions in its place; None if no cell did."""
        return self if self.has_floor else self._cells.at_random(self.cell)

    @cached_property
    def _evaluated(self) -> Mapping[int, Part]:
        named = {steps: f"{EVALUATIONS}/{path.name}" for steps, path in evaluation_files(self._files).items()}
        files = {**{steps: name for steps, name in named.items() if self._is_there(name)}, self.cell.steps: EVALUATION}
        found = {}
        for steps, file in files.items():
            with self:
                paid = {self.reward: self.recorded_return("return", file)}
                found[steps] = Part(self._count(file), paid, self._measure(file), {})
        return found

    @cached_property
    def episodes(self) -> Episodes:  # type: ignore[override]  # read when it is asked for
        """The finished episodes of the training: what its own reward paid, and whether they reached the target."""
        last, reached, paid = self._ask(TRACE, "learned", learned).reshape(3, -1)
        return Episodes(last.astype(np.int64), {self.reward: paid}, {SUCCESS: reached}, {})

    def ends(self) -> tuple[Part, Part, Part]:
        with self:
            start, end = (
                part._replace(behaviour=self._measure(TRACE, of))
                for of, part in zip((START, END), self.episodes.ends, strict=True)
            )
            pay = self.recorded_return("return")
        evaluated = Part(next(iter(self.measured.episodes.values())), {self.reward: pay}, self.measured.own, {})
        return start, end, evaluated

    @cached_property
    def motion(self) -> str:
        """A digest of every joint position in the final evaluation."""

        def make(trace: Log) -> str:
            positions = trace["qpos"]
            return hashlib.sha256(repr(positions.shape).encode() + positions.tobytes()).hexdigest()

        return self._ask(EVALUATION, "motion", make)

    # What was paid

    @cached_property
    def longest(self) -> tuple[float, float]:
        """How long an episode can be, in steps and in seconds; infinite where its evaluation does not tell."""

        def make(trace: Log) -> list[float]:
            facts = episode_facts(trace)
            steps = facts.horizon or math.inf
            return [steps, steps * (facts.control_period or math.inf)]

        steps, seconds = self._ask(EVALUATION, "longest", make)
        return steps, seconds

    @cached_property
    def cut(self) -> int:  # type: ignore[override]
        """Rows of its training."""
        return self._ask(TRACE, "rows", len)

    @property
    def budget(self) -> int:
        return self.cell.steps

    @property
    def recorded(self) -> Float:
        """What the cell's own reward paid, every row of the training, (rows,)."""
        return self._ask(TRACE, "reward", lambda trace: trace["reward"])

    def paid(self, by: Any) -> Float:
        """See `Run`: its own reward's pay is recorded."""
        return self.recorded if by.reward == self.reward else self.paid_by(by.unchanged(TRACE))

    def paid_by(self, reward: InstalledReward) -> Float:
        """What another reward pays for every row of the training, (rows,).

        Raises:
            Unscored: It cannot.
        """
        return self._ask(TRACE, "paid", lambda trace: self._paid(trace, reward).total, reward)

    def unchanged(self, file: str) -> InstalledReward:
        """Its own reward, which still pays what the cell recorded in a file.

        Raises:
            Unscored: It cannot pay, or pays something else.
        """
        own = self._cells.installed(self.cell.reward)
        if not self._ask(file, "is paid", own.pays_recorded, own):
            raise Unscored(f"reward {self.reward} now pays its recorded steps differently: it has changed")
        return own

    def returned(self, by: Any, manner: str = "", *, with_events: bool = False) -> float:
        """See `Run`: in its evaluation; with events its own reward's, as it was recorded."""
        value = self.recorded_return("paid") if with_events else self.evaluation_return(by.unchanged(EVALUATION))
        if value is None:
            raise Unscored(f"no episode ended in the evaluation of seed {self.seed}")
        return value

    def evaluation_return(self, reward: InstalledReward) -> float | None:
        """What a reward pays for an episode of the final evaluation, mean; None without a finished one.

        Raises:
            Unscored: It cannot.
        """
        return self._ask(
            EVALUATION, "return", lambda trace: mean_over_episodes(self._paid(trace, reward).total, trace), reward
        )

    def recorded_return(self, of: str, file: str = EVALUATION) -> float | None:
        """What an episode in a file was paid, mean; None without a finished one.

        Args:
            of: ``return`` of the cell's own reward, ``events``, or ``paid``, which is both.
            file: An evaluation, or `RANDOM`.
        """
        return self._ask(file, of, lambda trace: mean_return(trace, SUMMED[of]))

    def random_pay(self) -> Float:
        reward, owner = self.unchanged(EVALUATION), self.floor_cell
        return owner.floor_returns(reward) if owner else np.zeros(0)

    def floor_returns(self, reward: InstalledReward) -> Float:
        """What a reward pays each episode of random actions that the cell evaluated, events included, (episodes,).

        Raises:
            Unscored: It cannot.
        """

        def make(trace: Log) -> Any:
            return episode_sums(self._paid(trace, reward).total + paid_in(trace, EVENTS), trace.episodes).tolist()

        return np.array(self._ask(RANDOM, "returns", make, reward), np.float64)

    def at_random(self) -> Part:
        """See `Run`: pay where a cell of the reward recorded it."""
        owner = self.floor_cell
        pay = owner.recorded_return("return", RANDOM) if owner and owner.reward == self.reward else None
        return Part(0, {self.reward: pay}, self.measured.random, {})

    @property
    def has_terms(self) -> bool:
        """See `Run`: whether its training recorded some."""
        return self._ask(TRACE, "has terms", lambda trace: bool(terms_of(trace)))

    def terms(self, by: Any, part: str) -> ByTerm | None:
        """See `Run`: what others pay its training is not asked for."""
        reward = self._cells.installed(by.cell.reward)
        if part != "random":
            is_asked = part != "training" or by.reward == self.reward
            return self.terms_paid(reward, FILES[part]) if is_asked else None
        with suppress(Unscored):
            return self.floor_cell.terms_paid(reward, RANDOM) if self.floor_cell else None
        return None

    def terms_paid(self, reward: InstalledReward, file: str) -> ByTerm:
        """What each term of a reward paid in a file of the cell; without terms of a reward that has none.

        Args:
            reward: The reward.
            file: `TRACE`, `EVALUATION` or `RANDOM`.

        Raises:
            Unscored: It cannot pay these steps.
        """
        is_own = reward.choice == self.cell.reward  # which needs no code of it

        def make(trace: Log) -> ByTerm:
            terms = terms_of(trace) if is_own else self._paid(trace, reward).terms
            return by_term(terms, trace.episodes, int((trace["step"] > 0).sum()))

        return ByTerm.again(*self._ask(file, "terms", make, None if is_own else reward))

    # How it is read

    def _ask(
        self, file: str, what: str, make: Callable[[Log], Told], by: InstalledReward | None = None, code: str = ""
    ) -> Told:
        """What a file of the cell says.

        Args:
            file: Its name.
            what: Is asked.
            make: Finds it out of the trace, of which it reads the columns that it needs, if it is not kept.
            by: The reward that pays for it.
            code: The digest of other code that it follows from.
        """
        if by:
            what, code = f"{what} {by.choice.label}", by.fingerprint(self.cell.reward)

        with self:
            return self._kept.told(f"{file} {what}", [*self._digests(file), code], lambda: make(self._trace(file)))

    def _trace(self, file: str) -> Log:
        if file not in self._read:
            self._read[file] = read_trace(self._files / file, most=self._most(file)).load()  # in one pass
        return self._read[file]

    def _digests_now(self, file: str) -> list[str]:
        """SHA-256 of the parts of a trace."""
        parts = parts_of(self._files / file)
        return [self._kept.digest(part.relative_to(self._files).as_posix()) for part in parts]

    def _paid(self, trace: Log, reward: InstalledReward) -> Paid:
        return reward.pay(trace, self.cell.reward)

    def _count(self, file: str) -> int:
        return self._ask(file, "episodes", lambda trace: len(trace.episodes))

    def _measured(self, file: str, part: str = "") -> Values:
        """Every metric of a trace, or of a part of it.

        The reason of a failure is noted but not kept, because the metric may be mended.
        """
        values = Values()
        for name, (metric, code) in self._cells.fingerprinted.items():
            values[name], make = None, partial(_value_of, metric, part)
            try:
                if isinstance(metric, Unmeasurable):  # no trace has to be read for it
                    raise Unmeasured(metric.reason)
                values[name] = self._ask(file, f"{part}{name}", make, code=code)
            except Unmeasured as error:
                self.reasons.setdefault(name, str(error))
        return values

    def _most(self, file: str) -> int:
        """The most rows that a trace can have by what the cell says of itself; each episode has a row at its start."""
        if file == TRACE:
            return 2 * self.cell.steps + SLACK
        return self.cell.evaluation_episodes * (1 + max(self.cell.steps, SLACK))

    def _is_there(self, name: str) -> bool:
        return name in self.manifest.files and (self._files / name).is_file()


def learned(trace: Log, columns: Sequence[str] = ("reward",)) -> Float:
    """Last row of each episode, whether it reached the target, what was paid: one after the other, in order.

    Args:
        trace: Of a training.
        columns: Of what is paid; without those of events that of the reward alone.
    """
    reached, paid = (episode_sums(it, trace.episodes) for it in (trace["reached"], paid_in(trace, columns)))
    last = np.array([rows[-1] for rows in trace.episodes], np.int64)
    return np.array([last, reached > 0, paid])[:, np.argsort(last)].ravel()


def _value_of(metric: Measure, part: str, trace: Log) -> float | None:
    """The value of a metric for a trace, or for its first or last episodes.

    What is known of each env's only episode does not belong to a part.
    """
    if not part:
        return value_of(metric, trace)
    episodes = sorted(trace.episodes, key=lambda rows: int(rows[-1]))
    count = part_of(len(episodes))
    chosen = episodes[:count] if part == START else episodes[-count:]
    rows = np.sort(np.concatenate([np.empty(0, np.int64), *chosen]))
    facts = replace(episode_facts(trace), ik_steps=None, work=None)
    return value_of(metric, with_episode_facts(trace.part(rows), facts))
