"""What a tuning found, as a terminal shows it."""

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from .trial import Search, TrialRecord, Tuned

SHOWN = 10
OF_ARM = ("success", "final distance")
"""What is shown where no trial has an outcome."""


def tuning_table(tuned: Tuned) -> RenderableType:
    """The best trials of each search, and why others failed."""
    return Group(*[part for search in tuned.searches for part in _search_parts(search)])


def params_text(trial: TrialRecord) -> str:
    """A trial's values of the searched parameters: ``learning_rate=0.003, net_arch=64x64``."""
    return ", ".join(f"{name}={_value_text(value)}" for name, value in trial.params.items())


def outcome_text(trial: TrialRecord) -> dict[str, str]:
    """What the policies of a trial did, by what it is called; empty if nothing is known."""
    outcome = trial.outcome
    if outcome is None:
        return {}
    if outcome.final_distance is None:
        return {outcome.measure.replace("_", " "): f"{outcome.success:.4g}"}
    return {"success": f"{outcome.success:.1%}", "final distance": f"{outcome.final_distance:.4f} m"}


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
    told = [outcome_text(trial) for trial in search.ranked[:SHOWN]]
    measured = list(dict.fromkeys(name for outcome in told for name in outcome)) or list(OF_ARM)
    for heading in ("trial", *measured, "cells"):
        table.add_column(Text(heading), justify="right", no_wrap=True)
    table.add_column(Text("status"), no_wrap=True)
    table.add_column(Text("settings"), overflow="fold")
    for trial, outcome in zip(search.ranked[:SHOWN], told, strict=True):
        values = [outcome.get(name, "-") for name in measured]
        row = [str(trial.number), *values, str(trial.cells), trial.status, params_text(trial)]
        table.add_row(*map(Text, row), style="bold" if trial == search.best else "")
    return table


def _value_text(value: object) -> str:
    if isinstance(value, list | tuple):
        return "x".join(_value_text(item) for item in value)
    return f"{value:g}" if isinstance(value, float) else str(value)
