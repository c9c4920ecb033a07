"""What rewards and measures that were written later say of a recorded training: ``scores-<n>.parquet``.

The file has a column for each, named as in the parts of the recording, and a row for each step of recorder n. The facts
about the columns stand in the file's metadata, as JSON. `read_recording` adds these columns to those of the recording.
"""

import json
from collections.abc import Callable, Container, Iterable, Mapping
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Annotated, NotRequired

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from pydantic import Field, with_config
from typing_extensions import TypedDict

from harness.arrays import Float
from harness.errors import NewerFormat, SchemaError
from harness.files.bounded import parse_json, reading, require_regular
from harness.files.parquet import require_room
from harness.files.whole_file import whole_file
from harness.log import Log
from harness.log.log import BEHAVIOUR, REWARD
from harness.record.file_forms import EXACT, read_form
from harness.record.recording.facts import (
    MOST_NAMES,
    Failure,
    LogColumn,
    Names,
    Source,
    facts_of,
    file_column,
    log_column,
)

FORMAT = 1
MOST_BYTES = 2**33
_FACTS = b"harness"


@dataclass(frozen=True, eq=False)
class Scores:
    """Columns for the steps of one recorder.

    Attributes:
        columns: By column of a log (``reward/calm``, ``behaviour/height``): its value for each step, (steps,). NaN
            from where it was given up.
        lower_is_better: Names of the measures among them of which less is better.
        higher_is_better: The same of more.
        sources: By column: the code behind it.
        failures: Columns that were given up, and where.
    """

    columns: Mapping[str, Float]
    lower_is_better: tuple[str, ...]
    sources: Mapping[str, Source]
    failures: tuple[Failure, ...] = ()
    higher_is_better: tuple[str, ...] = ()

    @property
    def terms(self) -> dict[str, tuple[str, ...]]:
        """By name of a reward that pays terms: what they are called, in order."""
        found: dict[str, tuple[str, ...]] = {}
        for column in self.columns:
            if (reward := reward_column(column, self.sources)) != column:
                name = reward.removeprefix(REWARD)
                found[name] = (*found.get(name, ()), column.removeprefix(f"{reward}/"))
        return found

    def added_to(self, log: Log) -> Log:
        """The log of the recorder, with these columns in place of earlier ones of the same names."""
        facts, whole = facts_of(log), [column for column in self.columns if column in self.sources]
        kept = tuple(failure for failure in facts.failed if failure.column not in self.columns)
        terms = {name: of for name, of in facts.terms.items() if f"{REWARD}{name}" not in self.columns}
        told = replace(
            facts,
            rewards=_both(facts.rewards, (it.removeprefix(REWARD) for it in whole if it.startswith(REWARD))),
            behaviour=_both(facts.behaviour, (it.removeprefix(BEHAVIOUR) for it in whole if it.startswith(BEHAVIOUR))),
            lower_is_better=_both(facts.lower_is_better, self.lower_is_better),
            higher_is_better=_both(facts.higher_is_better, self.higher_is_better),
            sources={**facts.sources, **self.sources},
            failed=(*kept, *self.failures),
            terms={**terms, **self.terms},
        )
        return replace(log, facts=told).add(self.columns)

    def with_earlier(self, earlier: "Scores | None") -> "Scores":
        """These columns, and those that only `earlier` has."""
        if earlier is None:
            return self
        kept = {
            name: it for name, it in earlier.columns.items() if reward_column(name, earlier.sources) not in self.columns
        }
        return Scores(
            {**kept, **self.columns},
            _both(earlier.lower_is_better, self.lower_is_better),
            {**{name: it for name, it in earlier.sources.items() if name in kept}, **self.sources},
            (*(failure for failure in earlier.failures if failure.column in kept), *self.failures),
            _both(earlier.higher_is_better, self.higher_is_better),
        )


def _both(names: Iterable[str], more: Iterable[str]) -> tuple[str, ...]:
    return tuple(dict.fromkeys((*names, *more)))


def reward_column(column: str, sources: Container[str]) -> str:
    """The column of the reward that a column of a term belongs to; of one that has a source itself."""
    return column if column in sources else column.rpartition("/")[0]


def scores_name(number: int) -> str:
    """The file of the scores of a recorder's steps."""
    return f"scores-{number}.parquet"


def write_scores(path: Path, scores: Scores) -> None:
    """Write the file, in place of an earlier one.

    Raises:
        OSError: It cannot be written.
    """
    facts = {
        "format": FORMAT,
        "lower_is_better": list(scores.lower_is_better),
        "higher_is_better": list(scores.higher_is_better),
        "sources": {file_column(column): asdict(source) for column, source in scores.sources.items()},
        "failures": [failure.to_json() for failure in scores.failures],
    }
    columns = {file_column(it) if it in scores.sources else it: values for it, values in scores.columns.items()}
    table = pa.table(columns).replace_schema_metadata({_FACTS: json.dumps(facts)})
    with whole_file(path) as partial:
        pq.write_table(
            table,
            partial,
            compression="zstd",
            use_dictionary=False,
            column_encoding=dict.fromkeys(columns, "BYTE_STREAM_SPLIT"),
            write_page_checksum=True,
        )


def read_scores(path: Path, count_steps: Callable[[], int]) -> Scores | None:
    """What `write_scores` wrote; None if there is no such file, or the recording went on since.

    Args:
        path: The file.
        count_steps: How many the recorder has recorded; not called without a file.

    Raises:
        SchemaError: It is damaged, or has more steps.
        NewerFormat: A newer version wrote it.
    """
    if not path.exists():
        return None
    with reading(path, "file of scores"):
        require_regular(path, MOST_BYTES)
        file, steps = pq.ParquetFile(path, page_checksum_verification=True), count_steps()
        if file.metadata.num_rows > steps:
            raise SchemaError(f"{path} scores {file.metadata.num_rows:,} steps, and the recording has {steps:,}")
        if file.metadata.num_rows < steps:
            return None
        facts = _facts_of(path, file.schema_arrow)
        require_room(file)
        table = file.read()
        columns = {
            log_column(name): np.asarray(table.column(name).to_numpy(), np.float64) for name in table.column_names
        }
        if any(np.isinf(values).any() for values in columns.values()):
            raise SchemaError(f"{path} has infinite numbers")
        return Scores(
            columns,
            facts["lower_is_better"],
            facts["sources"],
            facts["failures"],
            facts.get("higher_is_better", ()),
        )


def _facts_of(path: Path, schema: pa.Schema) -> "ScoresForm":
    told = parse_json((schema.metadata or {}).get(_FACTS, b"{}"))
    if isinstance(told, dict) and isinstance(number := told.get("format"), int) and number > FORMAT:
        raise NewerFormat(f"{path} has format {number}, this version reads up to {FORMAT}")
    facts = read_form(ScoresForm, told)
    for field in schema:
        reward = reward_column(log_column(field.name), facts["sources"])
        if reward not in facts["sources"] or not reward.startswith((REWARD, BEHAVIOUR)) or field.type != pa.float64():
            raise SchemaError(f"{path}: the column '{field.name}' is no column of scores")
    return facts


@with_config(EXACT)
class ScoresForm(TypedDict):
    """See `Scores`."""

    format: int
    lower_is_better: Names
    higher_is_better: NotRequired[Names]
    sources: Annotated[dict[LogColumn, Source], Field(max_length=2 * MOST_NAMES)]
    failures: Annotated[tuple[Failure, ...], Field(max_length=2 * MOST_NAMES)]
