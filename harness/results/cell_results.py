"""What follows from the files of one done cell, each thing computed once; see `harness.results.kept`."""

import hashlib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from harness.arrays import Float
from harness.errors import Unmeasured
from harness.eta.manner import OWN_AND_OTHER, TRAINING
from harness.log import Log
from harness.log.log import episode_sums
from harness.measure import Measure
from harness.record.cell import Cell
from harness.record.folder import EVALUATION, EVALUATIONS, RANDOM, SUFFIX, TRACE, evaluation_files
from harness.record.manifest import Manifest
from harness.record.returns import EVENTS, PAID, mean_over_episodes, mean_return, paid_in
from harness.record.store import Floor, Store, floors_in
from harness.record.trace import (
    FLAGS,
    INTEGERS,
    episode_facts,
    read_trace,
    require_plausible,
    term_names,
    terms_of,
    with_episode_facts,
)
from harness.results.by_term import ByTerm, by_term, part_of
from harness.results.kept import Kept
from harness.results.measured import Measured, Moment, Values, value_of
from harness.results.metrics import Unmeasurable
from harness.results.recordings.episodes import Part
from harness.reward import Paid
from harness.score.installed_reward import InstalledReward
from harness.score.scorer import SCORED

SLACK = 100_000
"""Rows that a trace may have beyond its training's budget, as the last decision of many envs may; and the steps that an
episode of an evaluation may have, where the training was shorter than that."""
MEASURED = (*INTEGERS, *FLAGS, "distance", *(f"end_effector_{axis}" for axis in "xyz"), "qpos")
"""Columns that metrics read."""
START, END = " start", " end"
"""The first and the last episodes of a training, see `harness.results.by_term.part_of`."""

SUMMED = {"return": ("reward",), "events": EVENTS, "paid": PAID}
"""What is summed over an episode."""
Metrics: TypeAlias = Callable[[], Mapping[str, tuple[Measure, str]]]


class CellResults:
    """The results of one done cell.

    Every method raises SchemaError if a file that it has to read is damaged, or written by a newer version. Columns
    that one method has read are kept for the others until `finish`.
    """

    def __init__(self, done: Manifest, files: Path, metrics: Metrics, kept: Kept) -> None:
        """Read nothing yet.

        Args:
            done: What the cell says of itself. Only files that it names are read.
            files: The folder of the cell.
            metrics: A function that gives the metrics by name, each with its fingerprint.
            kept: The numbers that are known already.
        """
        self.cell, self._files, self._metrics, self._kept = done.cell, files, metrics, kept
        self._done = done
        self._read: dict[str, Log] = {}
        self._reasons: dict[str, str] = {}

    def require_plausible(self) -> None:
        """See whether every trace of an arm's cell is one that the cell can have left, without reading its rows."""
        others = (f"{EVALUATIONS}/{path.name}" for path in evaluation_files(self._files).values())
        named = [EVALUATION, f"{OWN_AND_OTHER[self.cell.deterministic][1]}{SUFFIX}", RANDOM, *others, TRACE]
        there = [name for name in named if self._is_there(name)]

        def look() -> bool:
            for name in there:
                require_plausible(self._files / name, self._most(name))
            return True

        self._kept.number("is plausible", [self._kept.digest(name) for name in there], look)

    @property
    def has_floor(self) -> bool:
        """Whether the cell evaluated random actions."""
        return self._is_there(RANDOM)

    def floor(self) -> Values:
        """Every metric of the random actions that the cell evaluated."""
        return self._measure(RANDOM)

    def measured(self, floor: Values) -> Measured:
        """Every metric of the policy in both manners, of the training, and of random actions."""
        own, other = OWN_AND_OTHER[self.cell.deterministic]
        files = {own: EVALUATION, other: f"{other}{SUFFIX}", TRAINING: TRACE}
        there = {name: file for name, file in files.items() if name != other or self._is_there(file)}
        return Measured(
            {manner: self._measure(file) for manner, file in there.items()},
            {manner: self._episodes(file) for manner, file in there.items()},
            floor,
            self._reasons,
        )

    def moments(self) -> tuple[Moment, ...]:
        """Every evaluation in the cell's own manner, in order, the last one after its training."""
        named = {steps: f"{EVALUATIONS}/{path.name}" for steps, path in evaluation_files(self._files).items()}
        before = {steps: name for steps, name in named.items() if self._is_there(name)}
        files = {**before, self.cell.steps: EVALUATION}
        return tuple(Moment(steps, self._measure(file)) for steps, file in files.items())

    def ends(self) -> tuple[Part, Part]:
        """Every metric, and the pay, of the first episodes of the training and of the last."""
        paid = self.learned()[2]
        count = min(part_of(len(paid)), len(paid))
        start, end = (
            Part(count, {self.cell.reward.label: float(of.mean()) if count else None}, self._measure(TRACE, part), {})
            for part, of in ((START, paid[:count]), (END, paid[-count:]))
        )
        return start, end

    def learned(self) -> Float:
        """The finished episodes of the training, in the order in which they ended, (3, episodes).

        The rows say: its last row, counted from 0; whether it reached the target; what the cell's own reward paid.
        """
        digest = [self._kept.digest(TRACE)]
        return self._kept.array(f"{TRACE} learned", digest, self._learned).reshape(3, -1)

    def _learned(self) -> Float:
        trace = self._trace(TRACE)
        reached, paid = (episode_sums(trace[name], trace.episodes) for name in ("reached", "reward"))
        last = np.array([rows[-1] for rows in trace.episodes], np.int64)
        return np.array([last, reached > 0, paid])[:, np.argsort(last)].ravel()

    @property
    def has_read(self) -> bool:
        """Whether a trace had to be read since the last `finish`, because a result was not kept."""
        return bool(self._read)

    def keep_own(self) -> None:
        """Compute what a report asks of the cell beside metrics and what rewards pay again, if that is not kept."""
        self.rows()
        self.recorded()
        if not self.cell.evaluate_every:
            self.learned()
        self.recorded_return("events")
        self.recorded_return("paid")
        self.motion()

    def rows(self) -> int:
        """The number of rows of the training trace."""
        return int(self._number(TRACE, "rows", lambda: len(self._trace(TRACE))) or 0)

    def recorded(self) -> Float:
        """What the cell's own reward paid, every row of the training, (rows,)."""
        return self._kept.array(f"{TRACE} reward", [self._kept.digest(TRACE)], lambda: self._trace(TRACE)["reward"])

    def paid_by(self, reward: InstalledReward) -> Float:
        """What another reward pays for every row of the training, (rows,).

        Raises:
            Unscored: It cannot.
        """
        return self._kept.array(
            reward.choice.label, self._made_of(TRACE, reward), lambda: self._paid(TRACE, reward).total
        )

    def pays_recorded(self, reward: InstalledReward, file: str = TRACE) -> bool:
        """Whether the cell's own reward still pays what is recorded; see `InstalledReward.pays_recorded`."""
        what, made_of = f"{file} is paid by {reward.choice.label}", self._made_of(file, reward)
        return bool(self._kept.number(what, made_of, lambda: reward.pays_recorded(self._trace(file).load(SCORED))))

    def evaluation_return(self, reward: InstalledReward) -> float | None:
        """What a reward pays for an episode of the final evaluation, mean; None without a finished one.

        Raises:
            Unscored: It cannot.
        """
        return self._kept.number(
            f"{EVALUATION} return {reward.choice.label}",
            self._made_of(EVALUATION, reward),
            lambda: mean_over_episodes(self._paid(EVALUATION, reward).total, self._trace(EVALUATION)),
        )

    def terms_paid(self, reward: InstalledReward, file: str) -> ByTerm:
        """What each term of a reward paid in a file of the cell; without terms of a reward that has none.

        Args:
            reward: The reward.
            file: `TRACE`, `EVALUATION` or `RANDOM`.

        Raises:
            Unscored: It cannot pay these steps.
        """
        is_own = reward.choice == self.cell.reward  # which needs no code of it

        def make() -> dict[str, Any]:
            trace = self._trace(file)
            terms = terms_of(trace) if is_own else self._paid(file, reward).terms
            return by_term(terms, trace.episodes, trace["step"] > 0).to_json()

        made_of = [self._kept.digest(file)] if is_own else self._made_of(file, reward)
        return ByTerm.from_json(self._kept.told(f"{file} terms {reward.choice.label}", made_of, make))

    def recorded_return(self, of: str, file: str = EVALUATION) -> float | None:
        """What an episode in a file was paid, mean; None without a finished one.

        Args:
            of: ``return`` of the cell's own reward, ``events``, or ``paid``, which is both.
            file: `EVALUATION` or `RANDOM`.
        """
        return self._number(file, of, lambda: mean_return(self._trace(file), SUMMED[of]))

    def floor_returns(self, reward: InstalledReward) -> Float:
        """What a reward pays each episode of random actions that the cell evaluated, events included, (episodes,).

        Raises:
            Unscored: It cannot.
        """

        def make() -> Any:
            trace = self._trace(RANDOM)
            return episode_sums(self._paid(RANDOM, reward).total + paid_in(trace, EVENTS), trace.episodes).tolist()

        what = f"{RANDOM} returns {reward.choice.label}"
        return np.array(self._kept.told(what, self._made_of(RANDOM, reward), make), np.float64)

    def term_names(self) -> tuple[str, ...]:
        """The terms of the cell's own reward that its training recorded."""
        return term_names(self._files / TRACE)

    def motion(self) -> str:
        """A digest of every joint position in the final evaluation: equal where policies take the same steps."""

        def make() -> str:
            positions = self._trace(EVALUATION)["qpos"]
            return hashlib.sha256(repr(positions.shape).encode() + positions.tobytes()).hexdigest()

        return str(self._kept.told(f"{EVALUATION} motion", [self._kept.digest(EVALUATION)], make))

    def _made_of(self, file: str, reward: InstalledReward) -> list[str]:
        return [self._kept.digest(file), reward.fingerprint(self.cell.reward)]

    def _paid(self, file: str, reward: InstalledReward) -> Paid:
        return reward.pay(self._trace(file).load(SCORED), self.cell.reward)

    def _measure(self, file: str, part: str = "") -> Values:
        """Every metric of a trace, or of a part of it.

        The reason of a failure is noted but not kept, because the metric may be mended.
        """
        digest, values = self._kept.digest(file), Values()
        for name, (metric, fingerprint) in self._metrics().items():
            values[name], make = None, partial(self._apply, metric, file, part)
            try:
                values[name] = self._kept.number(f"{file}{part} {name}", [digest, fingerprint], make)
            except Unmeasured as error:
                self._reasons.setdefault(name, str(error))
        return values

    def _apply(self, metric: Measure, file: str, part: str) -> float | None:
        if isinstance(metric, Unmeasurable):  # no trace has to be read for it
            raise Unmeasured(metric.reason)
        trace = self._trace(file).load(MEASURED)
        return value_of(metric, _some(trace, part) if part else trace)

    def _episodes(self, file: str) -> int:
        """The finished episodes of a trace."""
        return int(self._number(file, "episodes", lambda: len(self._trace(file).episodes)) or 0)

    def _number(self, file: str, what: str, make: Callable[[], float | None]) -> float | None:
        """A number that a trace alone says."""
        return self._kept.number(f"{file} {what}", [self._kept.digest(file)], make)

    def _trace(self, file: str) -> Log:
        """A trace, of which results read the columns that they need."""
        if file not in self._read:
            self._read[file] = read_trace(self._files / file)
        return self._read[file]

    def _most(self, file: str) -> int:
        """The most rows that a trace can have by what the cell says of itself; each episode has a row at its start."""
        if file == TRACE:
            return 2 * self.cell.steps + SLACK
        return self.cell.evaluation_episodes * (1 + max(self.cell.steps, SLACK))

    def _is_there(self, name: str) -> bool:
        return name in self._done.files and (self._files / name).is_file()

    def finish(self) -> None:
        """Keep the numbers and drop the traces, because a report asks for one cell after the other."""
        self._read.clear()
        self._kept.save()


def _some(trace: Log, part: str) -> Log:
    """The first or the last episodes of a trace; what is known of each env's only episode does not belong to them."""
    episodes = sorted(trace.episodes, key=lambda rows: int(rows[-1]))
    count = part_of(len(episodes))
    chosen = episodes[:count] if part == START else episodes[-count:]
    rows = np.sort(np.concatenate([np.empty(0, np.int64), *chosen]))
    return with_episode_facts(trace.part(rows), replace(episode_facts(trace), ik_steps=None, work=None))


class Floors:
    """The floors of the cells in an experiment's folder."""

    def __init__(self, store: Store, manifests: Iterable[Manifest], of: Callable[[Cell], CellResults]) -> None:
        """Read nothing yet.

        Args:
            store: The folder.
            manifests: The manifests of its cells.
            of: A function that returns the results of a done cell.
        """
        self._of, self._owners = of, floors_in(manifests, store)
        self._values: dict[str, Values] = {}

    def of(self, cell: Cell) -> Values:
        """Every metric of random actions in a done cell's simulator, task and robot; empty if no cell has them."""
        owner = self.owner(cell)
        if owner is None:
            return {}
        if owner.id not in self._values:
            found = self._of(owner)
            self._values[owner.id] = found.floor()
            found.finish()
        return self._values[owner.id]

    def owner(self, cell: Cell) -> Cell | None:
        """The cell that evaluated random actions in the place of a done cell; None if no cell did."""
        return cell if self._of(cell).has_floor else self._owners.get(Floor.of(cell))
