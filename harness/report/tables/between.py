"""What changed between two experiments, as a terminal shows it."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.eta.behaviour_change import Change
from harness.eta.headline import count_seeds
from harness.report.rows.behaviour import behaviour_row
from harness.report.rows.comparison import Grid, answer_text
from harness.report.tables.grid import show_grid
from harness.results.between import Between, Pair, Verdict
from harness.results.overview import line_names, shared_text, short_value, success_text

HEADINGS = ("", "the policy", "success", "seeds", "the robot", "eta_N", "eta_P")
STYLES = {Verdict.BETTER.value.upper(): "bold green", Verdict.WORSE.value.upper(): "bold red"}
READING = (
    "before > after. the policy: whether the proposed reward's policies succeed more or less often than before, by a "
    "test over the seeds that are in both. the robot: whether the proposed reward helps beside the baseline."
)


def between_table(found: Between) -> RenderableType:
    """A line per combination, then the measures that moved, then what is in one of the experiments alone."""
    combinations = [pair.before for pair in found.pairs]
    names = line_names(combinations)
    rows = [_row(name, pair) for name, pair in zip(names, found.pairs, strict=True)]
    parts: list[RenderableType] = [Text(shared_text(combinations, with_seeds=False), style="bold")]
    parts += [*show_grid(Grid(HEADINGS, rows, []), STYLES), Text(), Text(READING, style="dim"), Text()]
    moved = [_moved(name, change) for name, pair in zip(names, found.pairs, strict=True) for change in pair.moved]
    parts += map(Text, moved or ["No measure moved by more than chance allows, all of them tested together."])
    for where, alone in (("first", found.only_before), ("second", found.only_after)):
        parts += [Text(f"only in the {where}: {it.group.title} · {it.proposed}") for it in alone]
    return Group(*parts)


def _row(name: str, pair: Pair) -> tuple[str, ...]:
    answers = [answer_text(it.headline) for it in (pair.before, pair.after)]
    etas = [[short_value(it.splits[name].eta) for it in (pair.before, pair.after)] for name in ("eta_N", "eta_P")]
    seeds = str(pair.success.seeds) if pair.success else "0"
    return (name, pair.verdict.value.upper(), success_text(pair.success), seeds, _change(answers), *map(_change, etas))


def _change(texts: list[str]) -> str:
    """Both texts, or one if they are alike."""
    return " > ".join(dict.fromkeys(texts))


def _moved(name: str, change: Change) -> str:
    row = behaviour_row(change)
    return (
        f"{name}: {row.name} is {change.direction}: {row.baseline} > {row.proposed}, difference {row.difference}; "
        f"{count_seeds(change.seeds)}, corrected p {row.p}"
    )
