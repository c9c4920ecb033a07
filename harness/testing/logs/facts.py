"""What the facts of a log tell: what is wrong with them, and the totals that its rows really have."""

import math
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

import numpy as np

from harness.log import Log, LogFacts, Unit
from harness.log.log import BEHAVIOUR


def faults_of(log: Log, path: Path) -> Iterator[str]:
    """A sentence for each fact that is not as it has to be.

    Args:
        log: One of the logs of the example.
        path: What was read.
    """
    if not log.facts.path.is_relative_to(path):
        yield f"facts.path is '{log.facts.path}', and '{path}' was read"
    if log.facts.unit not in get_args(Unit):
        yield f"facts.unit is {log.facts.unit!r}, none of {', '.join(get_args(Unit))}"
    yield from _faults_of_texts(log.facts)
    yield from _faults_of_numbers(log.facts)
    yield from _faults_of_columns(log)


def counts_of(log: Log) -> dict[str, int]:
    """The totals that a log's own rows have, by the names that `harness.log.LogFacts.declared` gives them."""
    if log.facts.unit == "episode":
        steps = {"steps": int(log["length"].sum())} if "length" in log else {}
        return {"episodes": len(log), **steps}
    if log.facts.unit == "step" and "episode" in log:
        starts = int(log["start"].sum()) if "start" in log else 0
        pairs = np.stack([log["env"] if "env" in log else 0 * log["episode"], log["episode"]])
        return {"episodes": np.unique(pairs, axis=1).shape[1], "steps": len(log) - starts}
    return {}


def _faults_of_texts(facts: LogFacts) -> Iterator[str]:
    if not facts.format:
        yield "facts.format is empty: say which program writes this"
    for text in (facts.format, facts.run, facts.trained_with, facts.env, facts.algorithm, facts.thinned, *facts.notes):
        if not isinstance(text, str) or "\n" in text:
            yield f"facts hold {text!r}, where one line of text is wanted"


def _faults_of_numbers(facts: LogFacts) -> Iterator[str]:
    if facts.seed is not None and type(facts.seed) is not int:  # a truth value is an int too
        yield f"facts.seed is {facts.seed!r}, neither an int nor None"
    for name, count in {"asked": facts.asked, **facts.declared}.items():
        if type(count) is not int or count < 0:
            yield f"facts tell {count!r} {name}, not a whole number of at least 0"
    for least, greatest in facts.bounds.values():
        if math.isnan(least) or not least < greatest:
            yield f"facts.bounds hold {least} to {greatest}"


def _faults_of_columns(log: Log) -> Iterator[str]:
    for name in (*log.facts.lower_is_better, *log.facts.bounds):
        if name not in log.measures:
            yield f"facts tell of the measure {name}, which has no column {BEHAVIOUR}{name}"
    for failed in log.facts.failed:
        if failed.column not in log or not failed.reason:
            yield f"facts.failed has {failed}: a column that there is, and the reason, are wanted"
