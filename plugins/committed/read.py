"""Reports from the committed records that ``harness report DIR --summary FOLDER`` leaves. They need no cell."""

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, NotRequired

from pydantic import ConfigDict, Field, with_config
from rich.console import Group, RenderableType
from rich.text import Text
from typing_extensions import TypedDict

from harness.errors import UsageError
from harness.eta import Answer, Change, Quantity, Ratio
from harness.eta.headline import SUCCESS, interval_text, ratio_text
from harness.eta.index import NEAR_ZERO
from harness.files import reading
from harness.files.bounded import parse_json, read_bytes
from harness.record import EXPERIMENT, PLAN
from harness.record.file_forms import Status, read_form
from harness.report import Grid
from harness.report.rows.comparison import POOLED_TITLE, interim_line
from harness.report.tables.comparison import WideOrNarrow
from harness.results.comparison import deciding_manner
from harness.results.overview import decided_by_text, measure_text, short_name
from harness.results.verdicts import COUNTED, UNKNOWN, missing_text
from harness.text import command_text

RECORD, SUMMARY = "results.json", "summary.md"
MOST_BYTES = 64 * 2**20
NUMBERS = ("seeds", "eta_N", "eta_P", "ruler")
PLACES = ("simulator", "algorithm", "robot", "task")
READING = (
    "{measure}: baseline -> proposed. eta_N and eta_P are the note's: the proposed reward's number divided by the "
    "baseline's. A wide terminal shows the 95% interval in brackets. By the note's rule an eta_N below 1 and an eta_P "
    "above 1 count as better. The ruler is the part of eta_P that is rescaling alone. *: see the remarks below."
)
Number = Annotated[float, Field(allow_inf_nan=False)]
Name = Annotated[str, Field(min_length=1, max_length=1_000)]
Line = Annotated[str, Field(max_length=100_000)]
Count = Annotated[int, Field(gt=0, lt=2**53)]
OPEN = ConfigDict(strict=True, extra="allow")


@with_config(OPEN)
class RatioForm(TypedDict):
    """See `harness.eta.index.Ratio`."""

    value: Number | None
    low: Number | None
    high: Number | None
    note: Line


@with_config(OPEN)
class SplitForm(TypedDict):
    """See `harness.eta.splits.Split`."""

    eta: RatioForm
    ruler: RatioForm


@with_config(OPEN)
class ChangeForm(TypedDict):
    """See `harness.eta.behaviour_change.Change`."""

    name: Name
    manner: Name
    baseline: Number | None
    proposed: Number | None
    episodes: NotRequired[int | None]
    unit: NotRequired[Line]


@with_config(OPEN)
class HeadlineForm(TypedDict):
    """See `harness.eta.headline.Headline`."""

    answer: Name
    robot: NotRequired[Line]
    behaviour: NotRequired[Line]
    number: Line
    decided_by: NotRequired[Name | None]


@with_config(OPEN)
class ComparisonForm(TypedDict):
    """See `harness.results.comparison.Comparison`."""

    simulator: NotRequired[Name]
    algorithm: NotRequired[Name]
    robot: NotRequired[Name]
    task: Name
    steps: Count
    deterministic: bool
    baseline: Name
    proposed: Name
    is_control: bool
    seeds: list[int]
    trained: NotRequired[dict[Name, list[int]]]
    headline: HeadlineForm
    eta_N: SplitForm
    eta_P: SplitForm
    episodes: dict[Name, int]
    behaviour: list[ChangeForm]
    deciding: NotRequired[list[Name]]
    decided_in: NotRequired[Line]


@with_config(OPEN)
class CellForm(TypedDict):
    """The form of a cell in the records."""

    status: Status


@with_config(OPEN)
class PooledForm(TypedDict):
    """See `harness.results.comparison.Pool`."""

    answer: Name
    behaviour: Line


@with_config(OPEN)
class ChoosingForm(TypedDict):
    """See `harness.results.choosing.Choosing`."""

    told: Line


@with_config(OPEN)
class RecordForm(TypedDict):
    """The form of what ``harness report --json`` prints."""

    combinations: list[ComparisonForm]
    cells: list[CellForm]
    over_places: NotRequired[list[PooledForm]]
    choosing: NotRequired[ChoosingForm | None]
    recovered: NotRequired[Line]


@with_config(OPEN)
class AgentHeadlineForm(TypedDict):
    """The form of the headline of a comparison of recorded trainings."""

    answer: Name
    agent: Line


@with_config(OPEN)
class PairForm(TypedDict):
    """The form of one comparison of recorded trainings."""

    baseline: Name
    proposed: Name
    headline: AgentHeadlineForm


@with_config(OPEN)
class StudyForm(TypedDict):
    """The form of what recorded trainings in one place say."""

    comparisons: list[PairForm]


@with_config(OPEN)
class PlaceForm(TypedDict):
    """The form of one place: an environment and an algorithm."""

    task: Name
    algorithm: Name
    reason: Line
    study: StudyForm | None


@with_config(OPEN)
class EnvironmentsForm(TypedDict):
    """The form of what ``harness report --json`` prints for an experiment whose task is an environment."""

    studies: list[PlaceForm]
    cells: list[CellForm]


def is_committed(folder: Path) -> bool:
    """Whether a folder holds records, but no experiment."""
    return (folder / RECORD).is_file() and not (folder / PLAN).exists()


def committed_text(folder: Path) -> str:
    """The records as JSON.

    Raises:
        SchemaError: The file is damaged.
    """
    with reading(folder / RECORD, "record"):
        return read_bytes(folder / RECORD, MOST_BYTES).decode("utf-8").rstrip("\n")


def committed_table(folder: Path) -> RenderableType:
    """A table of the records: what is the same in all comparisons, a line for each, and where to find more.

    Raises:
        SchemaError: The file is damaged.
    """
    record, environments = _read(folder)
    cells = (record or environments or {"cells": []})["cells"]
    done = sum(cell["status"] == "done" for cell in cells)
    parts: list[RenderableType] = [Text(f"Committed records of {len(cells)} cells, {done} done.")]
    parts += _interim(record)
    if chosen := record and record.get("choosing"):
        parts += [Text(chosen["told"], style="bold"), Text()]
    if environments is not None:
        parts += [part for place in environments["studies"] for part in _place(place)]
    comparisons = record["combinations"] if record else []
    if comparisons:
        apart = [kind for kind in (*PLACES, "steps", "baseline") if len({_told(it, kind) for it in comparisons}) > 1]
        names = [" · ".join([*(_told(it, kind) for kind in apart), _proposed(it)]) for it in comparisons]
        kinds = (kind for kind in (*PLACES, "baseline", "steps") if kind not in apart)
        shared = [label for kind in kinds if (label := _told(comparisons[0], kind))]
        grids = ([_grid(names, comparisons, with_intervals)] for with_intervals in (True, False))
        parts += [Text(" · ".join(shared), style="bold"), WideOrNarrow(*grids)]
        reading = READING.format(measure=_measure(comparisons))
        parts += [Text(), Text(reading, style="dim"), *map(Text, _remarks(names, comparisons))]
    pools = record.get("over_places", []) if record else []
    lines = [f"{POOLED_TITLE}: {it['answer'].upper()}. {it['behaviour']}" for it in pools]
    if len(comparisons) == 1:
        told = comparisons[0]["headline"]
        lines = [told.get("behaviour", told.get("robot", "")), told["number"]]
    parts += [part for line in lines if line for part in (Text(), Text(line))]
    return Group(*parts, Text(), Text(_more(folder)))


def refuse_committed(folder: Path, flag: str) -> None:
    """Refuse a flag that needs cells, and say what can be done instead.

    Raises:
        UsageError: The folder holds records alone.
    """
    if is_committed(folder):
        raise UsageError(f"{flag} needs cells, and '{folder}' holds only records. {_more(folder)}")


def _read(folder: Path) -> tuple[RecordForm | None, EnvironmentsForm | None]:
    """The records of an experiment with an arm, or of one whose task is an environment."""
    with reading(folder / RECORD, "record"):
        data = parse_json(read_bytes(folder / RECORD, MOST_BYTES))
        if isinstance(data, dict) and "studies" in data and "format" not in data:  # of version 0.1
            read_form(EnvironmentsForm, data)
            return None, data  # type: ignore[return-value] # its form was just checked
        read_form(RecordForm, data)
        return data, None


def _place(place: PlaceForm) -> list[RenderableType]:
    """Lines on what was found in one environment with one algorithm."""
    parts: list[RenderableType] = [Text(), Text(f"{place['task']} · {place['algorithm']}", style="bold")]
    if place["study"] is None:
        return [*parts, Text(f"{place['reason']}.")]
    for pair in place["study"]["comparisons"]:
        told = pair["headline"]
        parts.append(Text(f"{pair['proposed']} against {pair['baseline']}: {told['answer'].upper()}. {told['agent']}"))
    return parts


def _more(folder: Path) -> str:
    return (
        f"All numbers and figures: {folder / SUMMARY}. To train its cells again, for the page and the replay: "
        + command_text("harness", "run", folder / EXPERIMENT, "--out", "NEW")
    )


def _told(comparison: ComparisonForm, kind: str) -> str:
    if kind == "steps":
        return f"{comparison['steps']:,} steps"
    label = str(dict(comparison).get(kind, ""))
    return f"against {label}" if kind == "baseline" else label


def _proposed(comparison: ComparisonForm) -> str:
    return f"{comparison['proposed']}{' (other seeds)' if comparison['is_control'] else ''}"


def _grid(names: Sequence[str], comparisons: Sequence[ComparisonForm], with_intervals: bool) -> Grid:
    rows = [_row(name, it, with_intervals) for name, it in zip(names, comparisons, strict=True)]
    subject = "robot" if any("robot" in it for it in comparisons) else "agent"
    return Grid(("", f"the {subject}", "decided by", _measure(comparisons), *NUMBERS), rows, [])


def _measure(comparisons: Sequence[ComparisonForm]) -> str:
    """The name of the measure that decides."""
    return " / ".join(map(short_name, dict.fromkeys(_deciding(it)[0] for it in comparisons)))


def _deciding(comparison: ComparisonForm) -> list[str]:
    """The measures that decide, of which a record may name none."""
    return comparison.get("deciding") or [SUCCESS]


def _row(name: str, comparison: ComparisonForm, with_intervals: bool) -> tuple[str, ...]:
    ratios = _ratios(comparison)
    decider, first = comparison["headline"].get("decided_by"), _deciding(comparison)[0]
    return (
        name,
        comparison["headline"]["answer"].upper(),
        decided_by_text(decider, first, _values(comparison, decider)),
        _values(comparison, first),
        _counts(comparison),
        *(_ratio(it, with_intervals) for it in ratios.values()),
    )


def _counts(comparison: ComparisonForm) -> str:
    """How many trainings each reward has; up to version 0.2 the seeds that both have."""
    counts = [len(seeds) for seeds in comparison.get("trained", {}).values()] or [len(comparison["seeds"])]
    return " / ".join(map(str, dict.fromkeys(counts)))


def _interim(record: RecordForm | None) -> list[RenderableType]:
    """A line that the plan was not trained to its end when the records were written; none where it was."""
    if record is None or all(it["headline"]["answer"] != Answer.INTERIM for it in record["combinations"]):
        return []
    missing = sum(cell["status"] not in COUNTED for cell in record["cells"])
    return [Text(interim_line(missing_text(UNKNOWN if record.get("recovered") else missing)))]


def _ratio(ratio: RatioForm, with_intervals: bool) -> str:
    weak = ratio["note"] if NEAR_ZERO in ratio["note"] else None
    found = Ratio(ratio["value"], ratio["low"], ratio["high"], near_zero=weak)
    interval = interval_text(found, missing="") if with_intervals else ""
    return f"{ratio_text(found)}{'*' * bool(ratio['note'])} {interval}".rstrip()


def _ratios(comparison: ComparisonForm) -> dict[str, RatioForm]:
    return {
        "eta_N": comparison["eta_N"]["eta"],
        "eta_P": comparison["eta_P"]["eta"],
        "ruler": comparison["eta_P"]["ruler"],
    }


def _remarks(names: Sequence[str], comparisons: Sequence[ComparisonForm]) -> list[str]:
    """Remarks on numbers, each said once with all comparisons that it holds for."""
    found: dict[str, list[str]] = {}
    for name, comparison in zip(names, comparisons, strict=True):
        for column, ratio in _ratios(comparison).items():
            if ratio["note"]:
                found.setdefault(f"{column}: {ratio['note']}", []).append(name)
    return [f"* {', '.join(where)}: {note}" for note, where in found.items()]


def _values(comparison: ComparisonForm, key: str | None) -> str:
    """Both values of a measure, see `harness.eta.headline.key_of`; success as a percentage."""
    name, _, manner = (key or "").partition(" ")
    decided = (
        manner or comparison.get("decided_in") or deciding_manner(comparison["deterministic"], comparison["episodes"])
    )
    for it in comparison["behaviour"]:
        if (it["name"], it["manner"]) == (name, decided):
            episodes = it.get("episodes") or (1 if name == SUCCESS else None)
            measure = Quantity(name, it.get("unit", ""), "", decided, episodes)
            return measure_text(Change(measure, it["baseline"], it["proposed"], None))
    return measure_text(None)
