"""What follows from the files of one done cell, each thing computed once; see `harness.results.kept`."""

import hashlib
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import TypeAlias

import numpy as np

from harness.arrays import Float
from harness.errors import Unmeasured
from harness.eta.behaviour_change import TRAINING
from harness.measure import Measure
from harness.record.cell_folder import is_named
from harness.record.folder import EVALUATION, EVALUATIONS, RANDOM, TRACE, evaluation_files, other_manner
from harness.record.manifest import Manifest
from harness.record.returns import EVENTS, mean_over_episodes, mean_return
from harness.record.trace import Trace, read_trace, require_plausible
from harness.results.kept import Kept
from harness.results.measured import DETERMINISTIC, STOCHASTIC, Measured, Moment, Values, value_of
from harness.results.metrics import Unmeasurable
from harness.score.scored_runs import Payer
from harness.score.scorer import SCORED

SLACK = 100_000
"""Rows that a trace may have beyond its training's budget, as the last decision of many envs may; and the steps that an
episode of an evaluation may have, where the training was shorter than that."""
TO_PAY = [*SCORED, "episode", "reward", *EVENTS]
"""Columns that a reward is computed from, or a return."""


Metrics: TypeAlias = Callable[[], Mapping[str, tuple[Measure, str]]]


class CellResults:
    """The results of one done cell.

    Every method raises SchemaError if a file that it has to read is damaged, or written by a newer version. A trace
    that one method has read is kept for the others until `finish`.
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
        self._read: dict[tuple[str, bool], Trace] = {}
        self._reasons: dict[str, str] = {}

    def require_plausible(self) -> None:
        """See whether every trace of an arm's cell is one that the cell can have left, without reading its rows."""
        others = (f"{EVALUATIONS}/{path.name}" for path in evaluation_files(self._files).values())
        named = [EVALUATION, other_manner(self.cell.deterministic), RANDOM, *others, TRACE]
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
        own, other = (DETERMINISTIC, STOCHASTIC) if self.cell.deterministic else (STOCHASTIC, DETERMINISTIC)
        files = {own: EVALUATION, other: other_manner(self.cell.deterministic), TRAINING: TRACE}
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

    def learned(self) -> Float:
        """The finished episodes of the training, in the order in which they ended, (3, episodes).

        The rows say: its last row, counted from 0; whether it reached the target; what the cell's own reward paid.
        """
        digest = [self._kept.digest(TRACE)]
        return self._kept.array(f"{TRACE} learned", digest, self._learned).reshape(3, -1)

    def _learned(self) -> Float:
        trace = self._trace(TRACE)
        reached, paid = trace["reached"], trace["reward"]
        told = [(rows[-1], reached[rows].any(), paid[rows].sum()) for rows in trace.episodes]
        return np.array(sorted(told), np.float64).reshape(-1, 3).T.ravel()

    def rows(self) -> int:
        """The number of rows of the training trace."""
        rows = self._kept.number(f"{TRACE} rows", [self._kept.digest(TRACE)], lambda: len(self.recorded()))
        return int(rows or 0)

    def recorded(self) -> Float:
        """What the cell's own reward paid, every row of the training, (rows,)."""
        what, made_of = f"{TRACE} reward", [self._kept.digest(TRACE)]
        return self._kept.array(what, made_of, lambda: self._training_with_reward()["reward"])

    def paid_by(self, payer: Payer) -> Float:
        """What another reward pays for every row of the training, (rows,).

        Raises:
            Unscored: It cannot.
        """
        made_of = [self._kept.digest(TRACE), payer.fingerprint]
        return self._kept.array(
            payer.choice.label, made_of, lambda: payer.pay(self._trace(TRACE, whole=payer.reads_more))
        )

    def pays_recorded(self, payer: Payer, file: str = TRACE) -> bool:
        """Whether the cell's own reward still pays what is recorded; see `Payer.pays_recorded`."""
        made_of = [self._kept.digest(file), payer.fingerprint]
        what = f"{file} is paid by {payer.choice.label}"
        return bool(
            self._kept.number(what, made_of, lambda: payer.pays_recorded(self._trace(file, whole=payer.reads_more)))
        )

    def evaluation_return(self, payer: Payer) -> float | None:
        """What a reward pays for an episode of the final evaluation, mean; None without a finished one.

        Raises:
            Unscored: It cannot.
        """

        def make() -> float | None:
            trace = self._trace(EVALUATION, whole=payer.reads_more)
            return mean_over_episodes(payer.pay(trace), trace)

        made_of = [self._kept.digest(EVALUATION), payer.fingerprint]
        return self._kept.number(f"{EVALUATION} return {payer.choice.label}", made_of, make)

    def evaluation_events(self) -> float | None:
        """What the events of an episode of the final evaluation paid, mean; None without a finished one."""
        what, made_of = f"{EVALUATION} events", [self._kept.digest(EVALUATION)]
        return self._kept.number(what, made_of, lambda: mean_return(self._trace(EVALUATION, whole=False), EVENTS))

    def motion(self) -> str:
        """A digest of every joint position in the final evaluation: equal where policies take the same steps."""

        def make() -> str:
            positions = self._trace(EVALUATION)["qpos"]
            return hashlib.sha256(repr(positions.shape).encode() + positions.tobytes()).hexdigest()

        return str(self._kept.told(f"{EVALUATION} motion", [self._kept.digest(EVALUATION)], make))

    def _measure(self, file: str) -> Values:
        """Every metric of a trace. The reason of a failure is noted but not kept, because the metric may be mended."""
        digest, values = self._kept.digest(file), Values()
        for name, (metric, fingerprint) in self._metrics().items():
            values[name], make = None, partial(self._apply, metric, file)
            try:
                values[name] = self._kept.number(f"{file} {name}", [digest, fingerprint], make)
            except Unmeasured as error:
                self._reasons.setdefault(name, str(error))
        return values

    def _apply(self, metric: Measure, file: str) -> float | None:
        if isinstance(metric, Unmeasurable):  # no trace has to be read for it
            raise Unmeasured(metric.reason)
        return value_of(metric, self._trace(file))

    def _episodes(self, file: str) -> int:
        """The finished episodes of a trace."""
        digest = self._kept.digest(file)
        return int(self._kept.number(f"{file} episodes", [digest], lambda: len(self._trace(file).episodes)) or 0)

    def _trace(self, file: str, whole: bool = True) -> Trace:
        """A trace, whole or only the columns that rewards need. It is read once for all results."""
        keys = [(file, True), (file, whole)]
        known = next((self._read[key] for key in keys if key in self._read), None)
        if known is None:
            known = self._read[file, whole] = read_trace(self._files / file, None if whole else TO_PAY)
        return known

    def _training_with_reward(self) -> Trace:
        """The training trace if it was read already. Else only its column of rewards, which is not kept in memory."""
        known = next((trace for (file, _), trace in self._read.items() if file == TRACE), None)
        return read_trace(self._files / TRACE, ["reward"]) if known is None else known

    def _most(self, file: str) -> int:
        """The most rows that a trace can have by what the cell says of itself; each episode has a row at its start."""
        if file == TRACE:
            return 2 * self.cell.steps + SLACK
        return self.cell.evaluation_episodes * (1 + max(self.cell.steps, SLACK))

    def _is_there(self, name: str) -> bool:
        return is_named(self._done, name) and (self._files / name).is_file()

    def finish(self) -> None:
        """Keep the numbers and drop the traces, because a report asks for one cell after the other."""
        self._read.clear()
        self._kept.save()
