"""The study of a search: Optuna draws the trials, and keeps them in a journal beside the cells."""

import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from harness.authoring.commands import read_bytes, reading
from harness.errors import UsageError

from .space import Dimension, Options
from .trial import Outcome, Status, TrialRecord

if TYPE_CHECKING:
    import optuna
    from optuna.samplers import BaseSampler
    from optuna.storages import JournalStorage
    from optuna.trial import FrozenTrial

JOURNAL = "study.log"
"""The file that grows beside the cells of the trials."""
OUTCOME, REASON, CELLS, REFUSED = "outcome", "reason", "cells", "refused"
MOST_BYTES = 256 * 2**20
"""The most bytes of a journal. 10,000 trials of ten parameters take a tenth of this."""
STARTUP_TRIALS = 5
"""The number of finished trials before the first trial may be pruned."""


def require_optuna() -> None:
    """Raise UsageError if Optuna is not installed."""
    try:
        import optuna  # noqa: F401
    except ImportError as error:
        raise UsageError(f"harness tune needs {error.name}: pip install 'fd100-harness[tune]'") from error


def open_storage(folder: Path) -> "JournalStorage":
    """The journal in `folder`. The caller must have locked the folder.

    Raises:
        SchemaError: It is damaged or too large, or no regular file.
    """
    from optuna.storages import JournalStorage
    from optuna.storages.journal import JournalFileBackend

    path = folder / JOURNAL
    path.with_name(f"{JOURNAL}.lock").unlink(missing_ok=True)  # of a process that was killed while it wrote
    with reading(path, "study"):
        _drop_half_line(path)
        return JournalStorage(JournalFileBackend(str(path)))


def _drop_half_line(path: Path) -> None:
    """Remove a last line that was not written to its end, because it would spoil the next one."""
    if path.exists():
        content = read_bytes(path, MOST_BYTES)
        whole = content[: content.rfind(b"\n") + 1]
        if len(whole) < len(content):
            with path.open("r+b") as file:
                file.truncate(len(whole))


class Study:
    """The trials of one search. What it draws depends only on the seed and on the results of earlier trials."""

    def __init__(
        self, storage: "JournalStorage", name: str, space: Sequence[Dimension], *, seed: int, pruner: str
    ) -> None:
        import optuna

        self._space, self._seed, self._storage, self._name = space, seed, storage, name
        pruners = {"median": lambda: optuna.pruners.MedianPruner(STARTUP_TRIALS), "none": optuna.pruners.NopPruner}
        with _quiet():
            self._study = optuna.create_study(
                storage=storage, study_name=name, direction="maximize", load_if_exists=True, pruner=pruners[pruner]()
            )

    @property
    def trials(self) -> list[TrialRecord]:
        """All trials, by number.

        Raises:
            SchemaError: The journal says what no trial has.
        """
        with reading(Path(JOURNAL), "study"):
            return [self._record(trial) for trial in self._drawn()]

    def is_over(self, trials: int) -> bool:
        """Whether there are as many trials as asked for, and all have ended."""
        found = self.trials
        return len(found) >= trials and all(trial.status != "running" for trial in found)

    def draw(self, first: dict[str, Any] | None) -> int:
        """Begin another trial.

        Args:
            first: Drawn values by parameter of the very first trial, if it has to be a certain one.

        Returns:
            Its number.
        """
        from optuna.trial import TrialState

        number = len(self._drawn())
        waiting = self._study.get_trials(deepcopy=False, states=(TrialState.WAITING,))
        if number == 0 and first is not None and not waiting:
            self._study.enqueue_trial(first)
        self._study.sampler = _sampler(self._seed, number)
        self._suggest(self._study.ask())
        return number

    def complete_drawing(self, number: int) -> None:
        """Draw the values that a trial lacks because its process was killed meanwhile. Values that were drawn stay."""
        self._suggest(self._resume(number))

    def report(self, number: int, step: int, value: float, outcome: Outcome, cells: int) -> None:
        """Note a trial's value after `step` + 1 seeds and `cells` cells. A step that was noted before stays."""
        trial = self._resume(number)
        trial.set_user_attr(OUTCOME, list(outcome))
        trial.set_user_attr(CELLS, cells)
        if step not in self._frozen(number).intermediate_values:
            trial.report(value, step)

    def is_hopeless(self, number: int) -> bool:
        """Whether the pruner would stop the trial after what was reported last."""
        return bool(self._resume(number).should_prune())

    def end(self, number: int, status: Status, value: float | None = None, reason: str = "") -> None:
        """End a trial; `value` is the value of a complete one."""
        from optuna.trial import TrialState

        if reason:
            self._resume(number).set_user_attr(REASON, reason)
        # A setting that cannot be is told as pruned, not as failed: the sampler learns from the one, not the other.
        states = {"complete": TrialState.COMPLETE, "failed": TrialState.FAIL}
        self._study.tell(number, value, states.get(status, TrialState.PRUNED))

    def _drawn(self) -> "list[FrozenTrial]":
        from optuna.trial import TrialState

        return [t for t in self._study.get_trials(deepcopy=False) if t.state != TrialState.WAITING]

    def _frozen(self, number: int) -> "FrozenTrial":
        return self._drawn()[number]

    def _resume(self, number: int) -> "optuna.Trial":
        """The trial to write to, no matter which process began it."""
        import optuna

        study_id = self._storage.get_study_id_from_name(self._name)
        trial_id = self._storage.get_trial_id_from_study_id_trial_number(study_id, number)
        self._study.sampler = _sampler(self._seed, number)
        return optuna.Trial(self._study, trial_id)

    def _suggest(self, trial: "optuna.Trial") -> None:
        for dimension in self._space:
            name = dimension.name
            if isinstance(dimension, Options):
                trial.suggest_categorical(name, dimension.texts)
            elif dimension.whole:
                trial.suggest_int(name, int(dimension.low), int(dimension.high), log=dimension.log)
            else:
                trial.suggest_float(name, dimension.low, dimension.high, log=dimension.log)

    def _record(self, trial: "FrozenTrial") -> TrialRecord:
        attrs = trial.user_attrs
        return TrialRecord(
            trial.number,
            _status(trial),
            {d.name: d.value(trial.params[d.name]) for d in self._space if d.name in trial.params},
            Outcome(*attrs[OUTCOME]) if OUTCOME in attrs else None,
            trial.value if trial.state.name == "COMPLETE" else None,
            attrs.get(CELLS, 0),
            attrs.get(REASON, ""),
        )


def _sampler(seed: int, number: int) -> "BaseSampler":
    """The sampler of one trial. So a search that goes on draws what it would have drawn without the stop."""
    import optuna
    from optuna.exceptions import ExperimentalWarning

    state = int(np.random.SeedSequence([seed, number]).generate_state(1)[0])
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ExperimentalWarning)  # constant_liar, in Optuna 4
        return optuna.samplers.TPESampler(seed=state, constant_liar=True)


def _status(trial: "FrozenTrial") -> Status:
    names: dict[str, Status] = {"COMPLETE": "complete", "FAIL": "failed", "RUNNING": "running"}
    return names.get(trial.state.name) or ("refused" if REASON in trial.user_attrs else "pruned")


@contextmanager
def _quiet() -> Iterator[None]:
    """Keep Optuna from writing on standard error within the block."""
    import optuna

    before = optuna.logging.get_verbosity()
    optuna.logging.set_verbosity(optuna.logging.WARNING)
    try:
        yield
    finally:
        optuna.logging.set_verbosity(before)
