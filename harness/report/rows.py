"""What a comparison says, as text: sentences and small grids that the terminal and the page share."""

import math
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import NamedTuple

from harness.eta.behaviour_change import Change
from harness.eta.curve import Kind
from harness.eta.decompose import Decomposition, Split, Splits
from harness.eta.index import Index, Ratio
from harness.eta.statistics import interval_notes
from harness.eta.verdict import SUCCESS
from harness.results import Results
from harness.results.combination import Combination

NOTHING = "n/a"
NEAR_ZERO = "near zero"
SCALES = "eta compares two rewards, each on its own scale: it does not yet say how the robot behaves."
SPLIT = (
    "eta = ruler x behaviour: the ruler is the same runs scored by the two rewards, "
    "the behaviour is the two trainings scored by one reward."
)
PATHS = (
    "The first path takes the ruler on the proposed runs and the behaviour under the baseline reward, the other path "
    "the ruler on the baseline's runs and the behaviour under the proposed reward; both multiply to eta."
)
NO_REWARD = "No reward enters the success rate and the other measures of behaviour."
BETTER = {"eta_N": "below 1", "eta_P": "above 1"}


class Grid(NamedTuple):
    """A small table, ready to print: a name in the first column, then values; notes below."""

    headings: tuple[str, ...]
    rows: list[tuple[str, ...]]
    notes: list[str]


class BehaviourRow(NamedTuple):
    """One measure of the trained policies and of random actions, ready to print."""

    name: str
    baseline: str
    proposed: str
    difference: str
    random: str
    better: str
    direction: str


BEHAVIOUR_HEADINGS = ("behaviour", "baseline", "proposed", "difference", "random", "better", "result")


def rewards_text(combination: Combination) -> str:
    """Which rewards were compared."""
    told = f"{combination.proposed} against {combination.baseline}"
    return f"{told} (A/A, the null control)" if combination.proposed == combination.baseline else told


def seeds_text(seeds: Sequence[int]) -> str:
    """How many seeds, and which."""
    noun = "seed" if len(seeds) == 1 else "seeds"
    return f"{len(seeds)} {noun} ({', '.join(map(str, seeds))})" if seeds else "no seed"


def ratio_grid(splits: Splits) -> Grid:
    """eta_N and eta_P with their intervals, beside what the baseline's own seeds give against each other."""
    rows: list[tuple[str, ...]] = [
        (name, ratio_text(split.eta), interval_text(split.eta), BETTER[name]) for name, split in splits.items()
    ]
    headings: tuple[str, ...] = ("proposed / baseline", "ratio", "95% interval", "better")
    notes = _lines(_remarks((name, split.eta) for name, split in splits.items()))
    if any(split.noise.value is not None for split in splits.values()):
        rows = [(*row[:3], interval_text(splits[row[0]].noise), row[3]) for row in rows]
        headings = (*headings[:3], "A/A noise", headings[3])
        noises = _remarks((name, split.noise) for name, split in splits.items())
        notes += [f"A/A noise of {line}" for line in _lines(noises)]
    return Grid(headings, rows, notes)


def split_grid(splits: Splits) -> Grid:
    """Both etas as ruler x behaviour, on both paths; what is said of the etas themselves is not said again."""
    headings = ("eta = ruler x behaviour", "ruler", "95% interval", "behaviour", "95% interval")
    known = {note for split in splits.values() for note in split.eta.notes}
    if not all(split.is_scored for split in splits.values()):
        reasons = dict.fromkeys(split.ruler.note for split in splits.values() if split.ruler != split.eta)
        return Grid(headings, [], [f"Not split into ruler x behaviour: {reason}" for reason in reasons])
    rows: list[tuple[str, ...]] = []
    remarks: list[tuple[str, str]] = []
    for name, split in splits.items():
        first, other = (split.ruler, split.behaviour), (split.other_ruler, split.other_behaviour)
        rows += [
            (f"{name} = {ratio_text(split.eta)}", *_cells(first)),
            ("  other path", *_cells(other)),
        ]
        parts = (f"{name} ruler", f"{name} behaviour", f"{name} other ruler", f"{name} other behaviour")
        remarks += _remarks(zip(parts, (*first, *other), strict=True), known)
    disagreements = [_disagreement(name, split) for name, split in splits.items() if split.paths_disagree]
    return Grid(headings, rows, disagreements + _lines(remarks))


def index_grid(decomposition: Decomposition | None, kind: Kind = "accumulated") -> Grid:
    """The indices of both mean curves of that kind; no rows without any."""
    headings = (f"{kind} reward", "baseline", "proposed")
    if decomposition is None:
        return Grid(headings, [], [])
    names = ("first negative step", "cross-over step", "steps of the mean curve", "I_N", "I_P")
    columns = _texts(decomposition.baseline), _texts(decomposition.proposed)
    return Grid(headings, list(zip(names, *columns, strict=True)), [])


def behaviour_grid(combination: Combination) -> Grid:
    """Every measure of the trained policies and of random actions, the success rate first."""
    rows = behaviour_rows(combination)
    if not rows:
        return Grid(BEHAVIOUR_HEADINGS, [], [])
    note = "difference: 95% interval of proposed - baseline; a result only where it leaves out 0"
    return Grid(BEHAVIOUR_HEADINGS, list(rows), [note, *interval_notes(len(combination.seeds))])


def behaviour_rows(combination: Combination) -> list[BehaviourRow]:
    """One row per measure."""
    ordered = sorted(combination.changes, key=lambda change: change.name != SUCCESS)
    return [behaviour_row(change) for change in ordered]


def corrected_text(combination: Combination, combinations: int) -> str:
    """The p-values that hold for all combinations together; empty for one alone, which needs no correction."""
    names = {"eta_n": "eta_N", "eta_p": "eta_P", "success": "success rate"}
    told = [f"{names[key]} {_format_p(p)}" for key, p in combination.corrected.items() if p is not None]
    if combinations < 2 or not told:
        return ""
    return f"p of no change, corrected for {combinations} combinations: {', '.join(told)}"


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


def ratio_text(ratio: Ratio) -> str:
    """The ratio, unless it says little because an index is near zero beside the other."""
    return format_number(ratio.value) if ratio.near_zero is None else NEAR_ZERO


def interval_text(ratio: Ratio, missing: str = NOTHING) -> str:
    """Its interval, under the same condition; `missing` where there is none."""
    if ratio.near_zero is not None or ratio.low is None or ratio.high is None:
        return missing
    return f"[{format_number(ratio.low)}, {format_number(ratio.high)}]"


def ratio_with_interval(ratio: Ratio) -> str:
    """The ratio, and its interval if there is one to show."""
    return f"{ratio_text(ratio)} {interval_text(ratio, missing='')}".rstrip()


def format_number(value: float | None) -> str:
    """Three significant digits, without an exponent where that is readable."""
    if value is None:
        return NOTHING
    rounded = float(f"{value:.2e}") + 0.0  # no -0.0: an interval may end there
    size = math.floor(math.log10(abs(rounded))) if rounded else 0
    if not -4 <= size < 6:
        return f"{rounded:.2e}"
    return f"{rounded:,.{max(0, 2 - size)}f}"


def _cells(path: tuple[Ratio, Ratio]) -> tuple[str, ...]:
    return tuple(text for ratio in path for text in (ratio_text(ratio), interval_text(ratio)))


def _remarks(ratios: Iterable[tuple[str, Ratio]], known: Collection[str] = ()) -> Iterator[tuple[str, str]]:
    """Of each ratio: its name, with n/a if it has no value, and one thing to keep in mind.

    What is `known` already is left out, unless it is why there is no value.
    """
    for name, ratio in ratios:
        for remark in ratio.remarks:
            if ratio.value is None:
                yield f"{name} {NOTHING}", remark
            elif remark not in known:
                yield name, remark


def _lines(remarks: Iterable[tuple[str, str]]) -> list[str]:
    """One line for each thing to keep in mind, with all that it holds for."""
    subjects: dict[str, list[str]] = {}
    for name, remark in remarks:
        subjects.setdefault(remark, []).append(name)
    return [f"{', '.join(names)}: {remark}" for remark, names in subjects.items()]


def _disagreement(name: str, split: Split) -> str:
    parts = (split.ruler, split.behaviour, split.other_ruler, split.other_behaviour)
    if any(part.near_zero is not None for part in parts):  # its number would be a big one
        return f"{name}: the two paths cannot be compared, a part is near zero"
    return f"{name}: {split.disagreement}"


def _texts(index: Index) -> Iterator[str]:
    for step in (index.first_negative, index.crossover):
        yield "never" if step is None else f"{step:,}"
    yield f"{index.steps:,}"
    for total in (index.I_N, index.I_P):
        yield f"{total:,.1f}"


def behaviour_row(change: Change) -> BehaviourRow:
    """One measure."""
    values = (change.baseline, change.proposed, change.random)
    # A metric without a unit is a number like any other; as a percentage it reads best while it is a share.
    is_share = not change.unit and all(value is None or 0.0 <= value <= 1.0 for value in values)
    baseline, proposed, random = map(_format_share if is_share else format_number, values)
    name = change.name.replace("_", " ")
    needs_unit = change.unit and change.unit not in name.split()
    return BehaviourRow(
        f"{name} [{change.unit}]" if needs_unit else name,
        baseline,
        proposed,
        _format_difference(change, is_share),
        random,
        change.better,
        change.direction,
    )


def _format_difference(change: Change, is_share: bool) -> str:
    if change.low is None or change.high is None:
        return NOTHING
    if is_share:  # percentage points
        return f"[{100 * change.low + 0.0:.1f}, {100 * change.high + 0.0:.1f}] pp"
    return f"[{format_number(change.low)}, {format_number(change.high)}]"


def _format_share(value: float | None) -> str:
    return NOTHING if value is None else f"{value:.1%}"


def _format_p(p: float) -> str:
    return "< 0.001" if p < 0.001 else f"{p:.3f}"
