"""What rewards and measures that were written later say of a recorded training: ``scores-<n>.parquet``.

The file has a column for each, named as in the parts of the recording, and a row for each step of recorder n. The facts
about the columns stand in the file's metadata, as JSON. `read_recording` adds these columns to those of the recording.

Scores are a log of the same steps. Its facts, `TrainingFacts`, tell the rewards and measures, the code behind each, and
where one was given up: its column holds NaN from there on.
"""

import json
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Any, NotRequired

import numpy as np
import pyarrow as pa
from pydantic import Field, with_config
from typing_extensions import TypedDict

from harness.errors import NewerFormat, SchemaError
from harness.files.bounded import parse_json, whole_file
from harness.files.parquet import require_room, write_packed
from harness.log import Log, in_memory
from harness.log.log import BEHAVIOUR, REWARD, Columns, joined
from harness.record.file_forms import EXACT, read_form
from harness.record.parts import open_part, rows_of
from harness.record.recording.facts import (
    MOST_NAMES,
    Failure,
    LogColumn,
    Names,
    Source,
    TrainingFacts,
    facts_of,
    file_column,
    log_column,
)

FORMAT = 1
_FACTS = b"harness"
NAMED = ("rewards", "behaviour", "lower_is_better", "higher_is_better")


def with_scores(log: Log, later: Log | None) -> Log:
    """A log, with the columns of scores of its steps in place of earlier ones of the same rewards and measures."""
    if later is None:
        return log
    facts, new = facts_of(log), facts_of(later)
    named: dict[str, Any] = {it: tuple(dict.fromkeys((*getattr(facts, it), *getattr(new, it)))) for it in NAMED}
    kept = {name: terms for name, terms in facts.terms.items() if name not in new.rewards}
    told = replace(
        facts,
        **named,
        sources={**facts.sources, **new.sources},
        failed=(*(it for it in facts.failed if it.column not in new.numbers), *new.failed),
        terms={**kept, **new.terms},
    )
    return replace(log, facts=told).add(later.rows().columns)


def scores_name(number: int) -> str:
    """The file of the scores of a recorder's steps."""
    return f"scores-{number}.parquet"


def write_scores(path: Path, scores: Log) -> None:
    """Write the file, in place of an earlier one.

    Raises:
        OSError: It cannot be written.
    """
    facts = facts_of(scores)
    told = {
        "format": FORMAT,
        "lower_is_better": facts.lower_is_better,
        "higher_is_better": facts.higher_is_better,
        "sources": {file_column(column): asdict(source) for column, source in facts.sources.items()},
        "failures": [failure.to_json() for failure in facts.failures],
    }
    columns = {
        **{file_column(name): scores[name] for name in facts.numbers},
        **{name: scores[name] for name in facts.term_columns},
    }
    with whole_file(path) as partial:
        write_packed(pa.table(columns).replace_schema_metadata({_FACTS: json.dumps(told)}), partial)


def read_scores(path: Path, steps: int) -> Log | None:
    """What `write_scores` wrote; None if the recording went on since.

    Args:
        path: The file.
        steps: How many the recorder has recorded.

    Raises:
        SchemaError: It is damaged, or has more steps.
        NewerFormat: A newer version wrote it.
    """
    with open_part(path, "file of scores") as file:
        if file.metadata.num_rows > steps:
            raise SchemaError(f"{path} scores {file.metadata.num_rows:,} steps, and the recording has {steps:,}")
        if file.metadata.num_rows < steps:
            return None
        told = parse_json((file.schema_arrow.metadata or {}).get(_FACTS, b"{}"))
        if isinstance(told, dict) and isinstance(number := told.get("format"), int) and number > FORMAT:
            raise NewerFormat(f"{path} has format {number}, this version reads up to {FORMAT}")
        form = read_form(ScoresForm, told)
        require_room(path, file)
        rows = joined([*rows_of(file, path, file.schema_arrow.names)])
        columns = {log_column(name): values for name, values in rows.items()}
        facts = _facts(path, form, columns)
        return in_memory(facts, columns)


def _facts(path: Path, form: "ScoresForm", columns: Columns) -> TrainingFacts:
    sources = form["sources"]
    terms: dict[str, tuple[str, ...]] = {}
    for column, values in columns.items():
        whole = column if column in sources else column.rpartition("/")[0]
        if whole not in sources or not whole.startswith((REWARD, BEHAVIOUR)) or values.dtype != np.float64:
            raise SchemaError(f"{path}: the column '{file_column(column)}' is no column of scores")
        if whole != column:
            name = whole.removeprefix(REWARD)
            terms[name] = (*terms.get(name, ()), column.removeprefix(f"{whole}/"))
    rewards, measures = (
        tuple(it.removeprefix(begin) for it in columns if it in sources and it.startswith(begin))
        for begin in (REWARD, BEHAVIOUR)
    )
    return TrainingFacts(
        path=path,
        rewards=rewards,
        trained_with="",
        behaviour=measures,
        lower_is_better=form["lower_is_better"],
        higher_is_better=form.get("higher_is_better", ()),
        sources=sources,
        failed=form["failures"],
        terms=terms,
    )


@with_config(EXACT)
class ScoresForm(TypedDict):
    """The facts beside the columns of scores."""

    format: int
    lower_is_better: Names
    higher_is_better: NotRequired[Names]
    sources: Annotated[dict[LogColumn, Source], Field(max_length=2 * MOST_NAMES)]
    failures: Annotated[tuple[Failure, ...], Field(max_length=2 * MOST_NAMES)]
