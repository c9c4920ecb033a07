"""What a tuning found, as a terminal shows it."""

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from harness.tune.trial import Search, TrialRecord, Tuned

SHOWN = 10


def tuning_table(tuned: Tuned) -> RenderableType:
    """The best trials of each search, and why others failed."""
    return Group(*[part for search in tuned.searches for part in _search_parts(search)])


def params_text(trial: TrialRecord) -> str:
    """A trial's values of the searched parameters: ``learning_rate=0.003, net_arch=64x64``."""
    return ", ".join(f"{name}={_value_text(value)}" for name, value in trial.params.items())


def outcome_text(trial: TrialRecord) -> tuple[str, str]:
    """Success and final distance; a dash if there is none."""
    if trial.outcome is None:
        return "-", "-"
    return f"{trial.outcome.success:.1%}", f"{trial.outcome.final_distance:.4f} m"


def _search_parts(search: Search) -> list[RenderableType]:
    counts = dict.fromkeys(("complete", "pruned", "failed", "refused"), 0)
    for trial in search.trials:
        counts[trial.status] = counts.get(trial.status, 0) + 1
    told = ", ".join(f"{count} {status}" for status, count in counts.items() if count)
    title = Text(f"{' and '.join(search.rewards)}: {len(search.trials)} trials, {told}", style="bold")
    reasons = [
        Text(f"trial {trial.number} {trial.status}: {trial.reason} ({params_text(trial)})")
        for trial in search.trials
        if trial.reason
    ]
    return [title, _table(search), *reasons, Text()]


def _table(search: Search) -> Table:
    """The table of a search. Its settings may wrap, its numbers may not."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False, padding=(0, 1, 0, 0))
    for heading in ("trial", "success", "final distance", "cells"):
        table.add_column(Text(heading), justify="right", no_wrap=True)
    table.add_column(Text("status"), no_wrap=True)
    table.add_column(Text("settings"), overflow="fold")
    for trial in search.ranked[:SHOWN]:
        row = [str(trial.number), *outcome_text(trial), str(trial.cells), trial.status, params_text(trial)]
        table.add_row(*map(Text, row), style="bold" if trial == search.best else "")
    return table


def _value_text(value: object) -> str:
    if isinstance(value, list | tuple):
        return "x".join(_value_text(item) for item in value)
    return f"{value:g}" if isinstance(value, float) else str(value)
