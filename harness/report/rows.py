"""What a comparison says, as text: sentences and small grids that the terminal and the page share."""

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from harness.eta.behaviour_change import Change
from harness.eta.decompose import Split
from harness.eta.index import Index, Ratio
from harness.eta.statistics import FEW_SEEDS
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


def combination_title(combination: Combination) -> str:
    """Where the two rewards were compared: simulator, algorithm, robot and task."""
    group = combination.group
    return " · ".join([group.simulator.label, group.algorithm.label, group.robot, group.task.label])


def rewards_text(combination: Combination) -> str:
    """Which rewards were compared."""
    told = f"{combination.proposed} against {combination.baseline}"
    return f"{told} (A/A, the null control)" if combination.proposed == combination.baseline else told


def seeds_text(seeds: Sequence[int]) -> str:
    """How many seeds, and which."""
    noun = "seed" if len(seeds) == 1 else "seeds"
    return f"{len(seeds)} {noun} ({', '.join(map(str, seeds))})" if seeds else "no seed"


def splits(combination: Combination) -> dict[str, Split]:
    """Both splits by the name of their eta; none without a seed."""
    decomposition = combination.decomposition
    return {"eta_N": decomposition.negative, "eta_P": decomposition.positive} if decomposition else {}


def is_split(combination: Combination) -> bool:
    """Whether the runs could be scored by the other reward."""
    return len(combination.curves) == 4


def ratio_grid(combination: Combination) -> Grid:
    """eta_N and eta_P with their intervals, beside what the baseline's own seeds give against each other."""
    etas = _etas(combination)
    rows: list[tuple[str, ...]] = [
        (name, ratio_text(ratio), interval_text(ratio), BETTER[name]) for name, ratio in etas.items()
    ]
    headings: tuple[str, ...] = ("proposed / baseline", "ratio", "95% interval", "better")
    notes = _notes(_parts(etas.items()))
    noises = {name: split.noise for name, split in splits(combination).items()}
    if any(noise.value is not None for noise in noises.values()):
        rows = [(*row[:3], interval_text(noises[row[0]]), row[3]) for row in rows]
        headings = (*headings[:3], "A/A noise", headings[3])
        notes += [f"A/A noise of {note}" for note in _notes(_parts(noises.items()))]
    return Grid(headings, rows, notes)


def split_grid(combination: Combination) -> Grid:
    """Both etas as ruler x behaviour, on both paths."""
    headings = ("eta = ruler x behaviour", "ruler", "95% interval", "behaviour", "95% interval")
    if not is_split(combination):
        reasons = dict.fromkeys(split.ruler.note for split in splits(combination).values())
        return Grid(headings, [], [f"Not split into ruler x behaviour: {reason}" for reason in reasons])
    rows, said, disagreements = [], [], []
    known = {part for _, part in _parts(_etas(combination).items())}
    for name, split in splits(combination).items():
        first, other = (split.ruler, split.behaviour), (split.other_ruler, split.other_behaviour)
        rows += [
            (f"{name} = {ratio_text(split.eta)}", *_cells(first)),
            ("  other path", *_cells(other)),
        ]
        named = zip((f"{name} ruler", f"{name} behaviour"), first, strict=True)
        others = zip((f"{name} other ruler", f"{name} other behaviour"), other, strict=True)
        said += [
            (who, part)
            for who, part in _parts([*named, *others])
            if part not in known or NEAR_ZERO in part or NOTHING in who
        ]
        disagreements += _disagreement(name, split)
    return Grid(headings, rows, disagreements + _notes(said))


def index_grid(combination: Combination) -> Grid:
    """The indices of both mean curves; no rows without a seed."""
    headings = ("accumulated reward", "baseline", "proposed")
    baseline, proposed = combination.baseline_index, combination.proposed_index
    if baseline is None or proposed is None:
        return Grid(headings, [], [])
    names = ("first negative step", "cross-over step", "steps of the mean curve", "I_N", "I_P")
    return Grid(headings, list(zip(names, _texts(baseline), _texts(proposed), strict=True)), [])


def behaviour_grid(combination: Combination) -> Grid:
    """Every measure of the trained policies and of random actions, the success rate first."""
    rows = behaviour_rows(combination)
    if not rows:
        return Grid(BEHAVIOUR_HEADINGS, [], [])
    count = len(combination.seeds)
    notes = ["difference: 95% interval of proposed - baseline; a result only where it leaves out 0"]
    if count < FEW_SEEDS:
        notes.append(
            f"{count} seeds: the interval is rough below {FEW_SEEDS}" if count > 1 else "one seed: no interval"
        )
    return Grid(BEHAVIOUR_HEADINGS, list(rows), notes)


def behaviour_rows(combination: Combination) -> list[BehaviourRow]:
    """One row per measure."""
    ordered = sorted(combination.changes, key=lambda change: change.name != SUCCESS)
    return [_behaviour_row(change) for change in ordered]


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
    return NEAR_ZERO if is_near_zero(ratio) else format_number(ratio.value)


def interval_text(ratio: Ratio) -> str:
    """Its interval, under the same condition."""
    if is_near_zero(ratio) or ratio.low is None or ratio.high is None:
        return NOTHING
    return f"[{format_number(ratio.low)}, {format_number(ratio.high)}]"


def is_near_zero(ratio: Ratio) -> bool:
    """Whether the ratio has a value, which rests on an index near zero beside its counterpart."""
    return ratio.value is not None and NEAR_ZERO in ratio.note


def format_number(value: float | None) -> str:
    """Three significant digits, without an exponent where that is readable."""
    if value is None:
        return NOTHING
    rounded = float(f"{value:.2e}") + 0.0  # no -0.0: an interval may end there
    size = math.floor(math.log10(abs(rounded))) if rounded else 0
    if not -4 <= size < 6:
        return f"{rounded:.2e}"
    return f"{rounded:,.{max(0, 2 - size)}f}"


def _etas(combination: Combination) -> dict[str, Ratio]:
    return {"eta_N": combination.eta_n, "eta_P": combination.eta_p}


def _cells(path: tuple[Ratio, Ratio]) -> tuple[str, ...]:
    return tuple(text for ratio in path for text in (ratio_text(ratio), interval_text(ratio)))


def _parts(ratios: Iterable[tuple[str, Ratio]]) -> Iterator[tuple[str, str]]:
    """Of each ratio: its name, with n/a if it has no value, and one thing to keep in mind."""
    for name, ratio in ratios:
        for part in ratio.note.split("; ") if ratio.note else []:
            yield (name if ratio.value is not None else f"{name} {NOTHING}", part)


def _notes(parts: Iterable[tuple[str, str]]) -> list[str]:
    """One line for each thing to keep in mind, with all that it holds for."""
    subjects: dict[str, list[str]] = {}
    for name, part in parts:
        subjects.setdefault(part, []).append(name)
    return [f"{', '.join(names)}: {part}" for part, names in subjects.items()]


def _disagreement(name: str, split: Split) -> list[str]:
    if not split.disagreement:
        return []
    if any(map(is_near_zero, (split.ruler, split.behaviour, split.other_ruler, split.other_behaviour))):
        return [f"{name}: the two paths cannot be compared, a part is near zero"]  # its number would be a big one
    return [f"{name}: {split.disagreement}"]


def _texts(index: Index) -> Iterator[str]:
    for step in (index.first_negative, index.crossover):
        yield "never" if step is None else f"{step:,}"
    yield f"{index.steps:,}"
    for total in (index.I_N, index.I_P):
        yield f"{total:,.1f}"


def _behaviour_row(change: Change) -> BehaviourRow:
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
