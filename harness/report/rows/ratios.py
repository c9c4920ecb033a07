"""Ratios of two rewards and their parts, as text and small grids that the terminal and the page share."""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING

from harness.eta.curve import Kind
from harness.eta.headline import Text, format_number, interval_text, number_sentence, value_text
from harness.eta.index import NOTHING, Estimate, Index
from harness.eta.splits import Decomposition, Split, SplitPath, Splits, SumSplit
from harness.eta.swaps import p_text
from harness.report.rows import Fact, Grid

if TYPE_CHECKING:
    from harness.score.compare import ComparedRuns

SCALES = "Each reward pays on its own scale, so that pay does not say how the {subject} behaves."
SPLIT = (
    "Each ratio is ruler x behaviour. The ruler is rescaling alone: both rewards pay the same runs. For the behaviour "
    "one reward pays the runs of both trainings."
)
LABELS = {"per_seed": "seed by seed", "noise": "noise"}
PARTS = ("", "ruler", "95% interval", "behaviour", "95% interval")
PATH_NAMES = ("proposed runs", "baseline's runs")
NEITHER = "neither"
UNKNOWN = "an unknown reward"
BETTER = {"eta_N": "below 1", "eta_P": "above 1"}


def scales_text(subject: str) -> str:
    """What eta does not say, of a ``robot`` or an ``agent``."""
    return SCALES.format(subject=subject)


def ratio_grid(splits: Splits) -> Grid:
    """eta_N and eta_P with their intervals, and beside them what single seeds and the baseline's own runs give."""
    rows: list[tuple[str, ...]] = [
        (
            name,
            value_text(split.eta),
            interval_text(split.eta),
            value_text(split.per_seed),
            interval_text(split.noise),
            p_text(split.corrected),
            better_of(name),
        )
        for name, split in splits.items()
    ]
    headings = ("", "ratio", "95% interval", "seed by seed", "noise", "p", "better")
    notes = lines_of(_remarks((name, split.eta) for name, split in splits.items()))
    known = {note for split in splits.values() for note in split.eta.notes}
    for part in ("per_seed", "noise"):
        told = ((f"{name} {LABELS[part]}", getattr(split, part)) for name, split in splits.items())
        notes += lines_of((name, remark) for name, remark in _remarks(told) if remark not in known)
    flags = [f"{name}: {flag}" for name, split in splits.items() for flag in split.flags]
    return Grid(headings, rows, [*notes, *flags], "proposed / baseline")


def split_grid(splits: Splits) -> Grid:
    """Both etas as ruler x behaviour. Remarks on the etas themselves are not repeated."""
    headings = (*PARTS, "interaction")
    if not all(split.is_scored for split in splits.values()):
        reasons = dict.fromkeys(split.ruler.note for split in splits.values() if split.ruler != split.eta)
        return Grid(headings, [], [f"Not split into ruler x behaviour: {reason}" for reason in reasons])
    parts = {name: SplitPath(split.ruler, split.behaviour) for name, split in splits.items()}
    rows: list[tuple[str, ...]] = [
        (name, *_cells(part), value_text(splits[name].interaction)) for name, part in parts.items()
    ]
    return Grid(headings, rows, _part_notes(parts, _known(splits.values())), "ruler x behaviour")


def split_grids(splits: Splits) -> list[Grid]:
    """The ratios, their parts, and both paths of every split."""
    return [ratio_grid(splits), split_grid(splits), path_grid(splits)]


def path_grid(splits: Splits) -> Grid:
    """Both paths whose mean each split is. Remarks on the split itself are not repeated."""
    parts = {
        f"{name} on {where}": path
        for name, split in splits.items()
        for where, path in zip(PATH_NAMES, split.paths, strict=False)
    }
    known = _known(splits.values()) | {
        remark for split in splits.values() for part in (split.ruler, split.behaviour) for remark in part.remarks
    }
    rows: list[tuple[str, ...]] = [(name, *_cells(path)) for name, path in parts.items()]
    return Grid(PARTS, rows, _part_notes(parts, known), "ruler x behaviour, on each path")


def sum_grid(total: SumSplit) -> Grid:
    """The change of I_N + I_P and its parts."""
    parts = {"change": total.change, "  of it ruler": total.ruler, "  of it behaviour": total.behaviour}
    rows: list[tuple[str, ...]] = [
        (name, format_number(part.value), interval_text(part)) for name, part in parts.items() if part.value is not None
    ]
    reasons = dict.fromkeys(part.note for part in parts.values() if part.note)
    return Grid(("", "difference", "95% interval"), rows, list(reasons), "I_N + I_P, proposed - baseline")


def index_grid(decomposition: Decomposition, kind: Kind = "accumulated") -> Grid:
    """The indices of both mean curves of that kind."""
    names = ("first negative step", "cross-over step", "steps of the mean curve", "I_N", "I_P", "I_N + I_P")
    columns = _texts(decomposition.baseline), _texts(decomposition.proposed)
    return Grid((f"{kind} reward", "baseline", "proposed"), list(zip(names, *columns, strict=True)), [])


def better_of(name: str) -> str:
    """Which side of 1 the note calls better for the ratio of that name; more pay is neither better nor worse."""
    return BETTER.get(name, NEITHER)


def value_rows(
    name: str, values: Sequence[Estimate | float | None], text: Text = format_number, *, with_points: bool = False
) -> list[tuple[str, ...]]:
    """A row of values, and below it the intervals of those that are means, where one is known.

    Args:
        name: What the row is called.
        values: Means, or single values, which have no interval.
        text: How they are written.
        with_points: Whether an interval without a width is shown too: it may be taken for certainty.
    """
    means = [it if isinstance(it, Estimate) else Estimate(it) for it in values]
    intervals = [interval_text(it, "", text) if with_points or it.low != it.high else "" for it in means]
    row = (name, *(value_text(it, text) for it in means))
    return [row, ("  95% interval", *intervals)] if any(intervals) else [row]


def _known(splits: Iterable[Split]) -> set[str]:
    """The remarks on the etas themselves."""
    return {remark for split in splits for remark in split.eta.remarks}


def _part_notes(parts: Mapping[str, SplitPath], known: Collection[str]) -> list[str]:
    """Remarks on rulers and behaviours, by what they are parts of."""
    named = ((f"{what} of {name}", part) for name, path in parts.items() for what, part in path._asdict().items())
    return lines_of(_remarks(named, known))


def _cells(path: SplitPath) -> tuple[str, ...]:
    return tuple(text for ratio in path for text in (value_text(ratio), interval_text(ratio)))


def _remarks(ratios: Iterable[tuple[str, Estimate]], known: Collection[str] = ()) -> Iterator[tuple[str, str]]:
    """For each ratio: its name, with n/a if it has no value, and a remark.

    A remark that is `known` already is left out, unless it says why there is no value.
    """
    for name, ratio in ratios:
        for remark in ratio.remarks:
            if ratio.value is None:
                yield f"{name} {NOTHING}", remark
            elif remark not in known:
                yield name, remark


def lines_of(remarks: Iterable[tuple[str, str]], count: int = 0) -> list[str]:
    """One line for each remark, with all that it holds for, unless that is all there is, of which there are `count`."""
    subjects: dict[str, list[str]] = {}
    for name, remark in remarks:
        subjects.setdefault(remark, []).append(name)
    return [it if len(names) == count else f"{', '.join(names)}: {it}" for it, names in subjects.items()]


def step_text(step: int | None) -> str:
    """When something happened."""
    return "never" if step is None else f"{step:,}"


def _texts(index: Index) -> Iterator[str]:
    yield from map(step_text, (index.first_negative, index.crossover))
    yield f"{index.steps:,}"
    for total in (index.I_N, index.I_P, index.total):
        yield f"{total:,.1f}"


def eta_facts(comparison: "ComparedRuns") -> list[Fact]:
    """Two groups of recorded runs: the number in words first, then what it rests on."""
    notes = tuple(f"* {note}" for note in comparison.notes)
    number = number_sentence(comparison.names, comparison.decomposition.splits)
    return [
        Fact(comparison_title(comparison), (runs_text(comparison), *notes)),
        Fact(number, grids=tuple(eta_grids(comparison))),
        Fact(lines=(scales_text("robot"),)),
    ]


def eta_grids(comparison: "ComparedRuns") -> list[Grid]:
    """Every number of two groups of recorded runs."""
    found = comparison.decomposition
    return [*split_grids(found.splits), sum_grid(found.total), index_grid(found, comparison.kind)]


def comparison_title(comparison: "ComparedRuns") -> str:
    """Which rewards were compared, as far as they are known."""
    names = {who: name or UNKNOWN for who, name in comparison.rewards.items()}
    return f"proposed {names['proposed']} against {names['baseline']}"


def runs_text(comparison: "ComparedRuns") -> str:
    """How many runs there are, and which part of them is not compared."""
    parts = []
    for who, count in comparison.runs.items():
        left_out = comparison.rows_left_out[who]
        cut = f" ({_count(left_out, 'row')} behind the shortest run left out)" if left_out else ""
        parts.append(f"{who} {_count(count, 'run')}{cut}")
    return ", ".join(parts) + (", event terms included" if comparison.with_events else "")


def _count(number: int, noun: str) -> str:
    return f"{number:,} {noun}{'s' * (number != 1)}"
