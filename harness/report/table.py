"""What a comparison says, as rows of text; and those rows as a terminal shows them."""

import math
from collections import Counter
from collections.abc import Iterable
from typing import NamedTuple

from rich import box
from rich.console import Group, RenderableType
from rich.table import Table
from rich.text import Text

from harness.index import Index, Ratio
from harness.results import Behaviour, Combination, Results

NOTHING = "n/a"
SCALES = (
    "eta compares two rewards, each on its own scale: it does not yet say how the robot behaves. "
    "No reward enters the success rate and the other measures of behaviour."
)
RATIO_HEADINGS = ("ratio, proposed / baseline", "value", "95% interval", "better")
INDEX_HEADINGS = ("accumulated reward", "baseline", "proposed")
BEHAVIOUR_HEADINGS = ("behaviour after training", "baseline", "proposed", "random", "better")


class RatioRow(NamedTuple):
    """A ratio of two indices, ready to print."""

    name: str
    value: str
    interval: str
    better: str


class IndexRow(NamedTuple):
    """One index of both mean curves, ready to print."""

    name: str
    baseline: str
    proposed: str


class BehaviourRow(NamedTuple):
    """One metric of the trained policies and of random actions, ready to print."""

    name: str
    baseline: str
    proposed: str
    random: str
    better: str


def comparison_table(results: Results) -> RenderableType:
    """What ``harness run`` and ``harness report`` print at the end: a block per combination, then the cells."""
    blocks: list[RenderableType] = [_combination_block(combination) for combination in results.combinations]
    if any(combination.seeds for combination in results.combinations):
        blocks.append(Text(f"{SCALES}\n"))
    blocks.append(Text(count_cells(results), style="bold"))
    return Group(*blocks, *map(Text, unfinished_cells(results)))


def combination_title(combination: Combination) -> str:
    """Where the two rewards were compared: simulator, algorithm, robot and task."""
    group = combination.group
    return " · ".join([group.simulator.label, group.algorithm.label, group.robot, group.task.label])


def seeds_text(seeds: tuple[int, ...]) -> str:
    """How many seeds, and which."""
    noun = "seed" if len(seeds) == 1 else "seeds"
    return f"{len(seeds)} {noun} ({', '.join(map(str, seeds))})" if seeds else "no seed"


def ratio_rows(combination: Combination) -> list[RatioRow]:
    """eta_N and eta_P with their intervals; `ratio_notes` says why one is missing."""
    return [
        RatioRow("eta_N", format_number(combination.eta_n.value), _interval(combination.eta_n), "below 1"),
        RatioRow("eta_P", format_number(combination.eta_p.value), _interval(combination.eta_p), "above 1"),
    ]


def ratio_notes(combination: Combination) -> list[str]:
    """What to know about the ratios; once where it holds for both."""
    subjects: dict[str, list[str]] = {}
    for name, ratio in (("eta_N", combination.eta_n), ("eta_P", combination.eta_p)):
        if ratio.note:
            subjects.setdefault(ratio.note, []).append(name if ratio.value is not None else f"{name} {NOTHING}")
    return [f"{', '.join(names)}: {note}" for note, names in subjects.items()]


def index_rows(combination: Combination) -> list[IndexRow]:
    """The indices of both mean curves; none without a finished pair."""
    baseline, proposed = combination.baseline_index, combination.proposed_index
    if baseline is None or proposed is None:
        return []
    names = ("first negative step", "cross-over step", "steps of the mean curve", "I_N", "I_P")
    return [IndexRow(*texts) for texts in zip(names, _texts(baseline), _texts(proposed), strict=True)]


def behaviour_rows(combination: Combination) -> list[BehaviourRow]:
    """Every metric of the trained policies and of random actions, the success rate first."""
    ordered = sorted(combination.behaviour, key=lambda metric: metric.name != "success_rate")
    return [_behaviour_row(metric) for metric in ordered]


def count_cells(results: Results) -> str:
    """How many cells there are, and how many ended how."""
    counts = Counter(manifest.status for manifest in results.manifests)
    noun = "cell" if counts.total() == 1 else "cells"
    ended = [f"{counts[status]} {status}" for status in ("done", "failed", "skipped", "pending") if counts[status]]
    return f"{counts.total()} {noun}: {', '.join(ended)}" if ended else "No cells"


def unfinished_cells(results: Results) -> list[str]:
    """A line for each failed cell; one for all that were skipped or wait for the same reason."""
    lines = [f"failed: {manifest.cell.title}: {manifest.reason}" for manifest in results.failed]
    waiting = [manifest for manifest in results.manifests if manifest.status in ("skipped", "pending")]
    counts = Counter((manifest.status, manifest.reason) for manifest in waiting)
    return lines + [f"{count} {status}: {reason}" for (status, reason), count in counts.items()]


def format_number(value: float | None) -> str:
    """Three significant digits, without an exponent where that is readable."""
    if value is None:
        return NOTHING
    rounded = float(f"{value:.2e}") + 0.0  # no -0.0: an interval may end there
    size = math.floor(math.log10(abs(rounded))) if rounded else 0
    if not -4 <= size < 9:
        return f"{rounded:.2e}"
    return f"{rounded:,.{max(0, 2 - size)}f}"


def _format_share(value: float | None) -> str:
    return NOTHING if value is None else f"{value:.1%}"


def _interval(ratio: Ratio) -> str:
    ends = [ratio.low, ratio.high]
    return NOTHING if None in ends else f"[{', '.join(map(format_number, ends))}]"


def _texts(index: Index) -> Iterable[str]:
    for step in (index.first_negative, index.crossover):
        yield "never" if step is None else f"{step:,}"
    yield f"{index.steps:,}"
    for total in (index.I_N, index.I_P):
        yield f"{total:,.1f}"


def _behaviour_row(metric: Behaviour) -> BehaviourRow:
    values = (metric.baseline, metric.proposed, metric.random)
    # A metric without a unit is a number like any other; as a percentage it reads best while it is a share.
    is_share = not metric.unit and all(value is None or 0.0 <= value <= 1.0 for value in values)
    baseline, proposed, random = map(_format_share if is_share else format_number, values)
    name = metric.name.replace("_", " ")
    needs_unit = metric.unit and metric.unit not in name.split()
    return BehaviourRow(f"{name} [{metric.unit}]" if needs_unit else name, baseline, proposed, random, metric.better)


def _combination_block(combination: Combination) -> RenderableType:
    parts: list[RenderableType] = [
        Text(combination_title(combination), style="bold"),
        Text(f"proposed {combination.proposed} against {combination.baseline}"),
        Text(f"{seeds_text(combination.seeds)} compared, {combination.group.steps:,} training steps per run\n"),
        _grid(RATIO_HEADINGS, ratio_rows(combination)),
        *map(Text, ratio_notes(combination)),
    ]
    if combination.seeds:
        parts += [Text(), _grid(INDEX_HEADINGS, index_rows(combination))]
        parts += [Text(), _grid(BEHAVIOUR_HEADINGS, behaviour_rows(combination))]
    return Group(*parts, Text())


def _grid(headings: tuple[str, ...], rows: Iterable[tuple[str, ...]]) -> Table:
    """Names to the left, which may wrap; numbers to the right, which may not."""
    table = Table(box=box.SIMPLE_HEAD, show_edge=False, pad_edge=False)
    for position, heading in enumerate(headings):
        if position:
            table.add_column(Text(heading), justify="right", no_wrap=True, min_width=8)
        else:
            table.add_column(Text(heading), overflow="fold", min_width=24)
    for row in rows:
        table.add_row(*map(Text, row))  # Text, not str: "[m]" is no markup
    return table
