"""The experiment that a tuning ends with."""

from collections.abc import Sequence
from pathlib import Path

import tomli_w

from harness.experiment.task_plan import table_of
from harness.files.whole_file import write_whole
from harness.registry.choice import choose
from harness.registry.registry import Registry
from harness.tune.folder import TUNED
from harness.tune.trial import Search, TrialRecord
from harness.tune.tuning import FIRST_SEED, Setup
from harness.tune.validation import VALIDATION_SEED


def write_tuned(folder: Path, setup: Setup, searches: Sequence[Search], registry: Registry) -> Path | None:
    """Write the best settings as an experiment file; None if a search has trials to do, or no complete one.

    With a search for each reward every reward meets the best settings of all: an experiment is a full matrix.
    """
    best = [search.best for search in searches]
    chosen = [trial for trial in best if trial is not None]
    if len(chosen) < len(best) or any(_is_open(search, setup) for search in searches):
        return None
    algorithms = list(
        dict.fromkeys(choose(registry, "algorithms", {**table_of(setup.base), **trial.params}) for trial in chosen)
    )
    plan = setup.plan(algorithms, setup.rewards, registry)
    resolved = {key: value for key, value in plan.resolved.items() if value is not None}
    write_whole(folder / TUNED, _comment(setup, searches) + tomli_w.dumps(resolved))
    return folder / TUNED


def _is_open(search: Search, setup: Setup) -> bool:
    ended = [trial for trial in search.trials if trial.status != "running"]
    return len(ended) < setup.tuning.trials


def _comment(setup: Setup, searches: Sequence[Search]) -> str:
    """Where the settings come from, for the reader of the file."""
    lines = [f"Chosen by harness tune: {setup.tuning.trials} trials, {setup.tuning.seeds} seeds from {FIRST_SEED} on,"]
    lines += [f"validation seed {VALIDATION_SEED}; harness run trains and evaluates with others."]
    lines += [_choice_line(search, search.best) for search in searches if search.best]
    return "".join(f"# {line}\n" for line in lines)


def _choice_line(search: Search, best: TrialRecord) -> str:
    settings = ", ".join(f"{key}={value}" for key, value in best.params.items())
    return f"{' and '.join(search.rewards)}: trial {best.number}, {settings}"
