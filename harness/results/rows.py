"""The comparisons as a table with a row for each, for programs and notebooks."""

from collections.abc import Iterator, Sequence
from typing import Any

import pyarrow as pa

from harness.eta.index import Ratio
from harness.results.comparison import Comparison

KINDS = ("simulator", "algorithm", "robot", "task")
_TEXT = {name: pa.string() for name in (*KINDS, "baseline", "proposed", "answer", "decided_by", "measure")}
_ENDS = ("", "_low", "_high")
_NUMBERS = (
    *("p", "p_corrected", "baseline_value", "proposed_value", "difference", "low", "high"),
    *(f"{name}{end}" for name in ("eta_N", "eta_P", "ruler", "behaviour") for end in _ENDS),
)
_COUNTS = ("steps", "seeds", "baseline_trainings", "proposed_trainings")
SCHEMA = pa.schema({**_TEXT, **dict.fromkeys(_COUNTS, pa.int64()), **dict.fromkeys(_NUMBERS, pa.float64())})
"""The columns: where both rewards trained, the answer with its test, the measure that decides, the numbers."""


def comparison_rows(comparisons: Sequence[Comparison]) -> pa.Table:
    """A row for each comparison; null where a number is not known.

    ``seeds`` are those that both rewards have; behaviour is compared over all trainings of each.
    ``measure`` is the first of the measures that decide, with both values, their difference and its 95 % interval.
    ``ruler`` and ``behaviour`` are the parts of ``eta`` of the mean return where there is one, else those of eta_P.
    """
    return pa.Table.from_pylist([dict(_row(it)) for it in comparisons], SCHEMA)


def _row(comparison: Comparison) -> Iterator[tuple[str, Any]]:
    labels, headline, ruling, change = (
        comparison.group.labels, comparison.headline, comparison.ruling, comparison.decisive,
    )  # fmt: skip
    yield from ((kind, labels.get(kind)) for kind in KINDS)
    yield from zip(("baseline", "proposed"), comparison.names, strict=True)
    yield from zip(_COUNTS, (comparison.group.steps, len(comparison.seeds), *comparison.counts), strict=True)
    yield from (("answer", headline.answer.value), ("decided_by", headline.decided_by))
    if ruling is not None:
        yield from (("p", ruling.p), ("p_corrected", ruling.corrected))
    if change is not None:
        yield from (("measure", change.name), ("baseline_value", change.baseline), ("proposed_value", change.proposed))
        yield from (("difference", change.difference), ("low", change.low), ("high", change.high))
    split = comparison.splits["eta_P"] if comparison.main is None else comparison.main.ratio
    for name, ratio in (
        *(("eta_N", comparison.eta_n), ("eta_P", comparison.eta_p)),
        *(("ruler", split.ruler), ("behaviour", split.behaviour)),
    ):
        yield from _ends(name, ratio)


def _ends(name: str, ratio: Ratio) -> Iterator[tuple[str, float | None]]:
    yield from zip((f"{name}{end}" for end in _ENDS), (ratio.value, ratio.low, ratio.high), strict=True)
