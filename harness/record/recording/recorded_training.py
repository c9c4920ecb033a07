"""Reads the folder of a recorded training."""

import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import SchemaError, UsageError
from harness.files.bounded import reading, require_regular
from harness.files.parquet import MOST_NUMBERS, require_room
from harness.record.recording.facts import BEHAVIOUR, REWARD, TrainingFacts, term_column
from harness.record.recording.scores import read_scores, scores_name
from harness.registry.choice import parse
from harness.reward.forms import weighted
from harness.reward.terms import sum_of

PART_ROWS = 65_536
"""The rows of every part but a recorder's last."""
PART_BYTES, MOST_PARTS, MOST_RECORDERS = 2**31, 100_000, 10_000
"""Most that is read of a recording."""

INTEGERS = ("env", "episode", "step")
FLAGS = ("terminated", "truncated")
ANSWER = "answer"
CALLS = ("seed", "resets", ANSWER)
"""The columns of a step whose action is recorded; `harness.recorder.calls.Calls` says what they are."""
STEPS = "steps-"
"""What the names of the parts begin with."""

FILES = ("recording-*.json", f"{STEPS}*.parquet", "scores-*.parquet")
"""Patterns of the files that a recording is read from."""
_FACTS = re.compile(r"recording-(0|[1-9]\d{0,5})\.json")


@dataclass(frozen=True, eq=False)
class RecordedTraining:
    """One training whose steps several rewards have scored.

    Rows stand in the order of time: rows of one batch together, by env. All arrays are (rows,).

    Attributes:
        facts: What is known of it beside its steps.
        time: How often the envs had been stepped before, int64; rows of one batch share it.
        env: Number of the env, int32.
        episode: Counted from 0 in each env, int32.
        step: Counted from 0 in each episode, int32.
        rewards: By name of the reward: what it pays for each step. NaN from the step on in which it was given up,
            see `TrainingFacts.failures`; never infinite.
        behaviour: By name of the measure: what it was after each step. NaN from where it was given up, and in
            steps that do not end an episode where the env told nothing.
        terminated: Whether the step ended the episode.
        truncated: Whether the episode was cut after the step.
        terms: By name of a reward that pays terms, what each term pays for each step; their sum in this order is what
            the reward pays, to the last bit.
    """

    facts: TrainingFacts
    time: NDArray[np.int64]
    env: NDArray[np.int32]
    episode: NDArray[np.int32]
    step: NDArray[np.int32]
    rewards: Mapping[str, Float]
    behaviour: Mapping[str, Float]
    terminated: NDArray[np.bool_]
    truncated: NDArray[np.bool_]
    terms: Mapping[str, Mapping[str, Float]] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.time)

    def weighed(self, labels: Iterable[str]) -> "RecordedTraining":
        """The same, and what rewards with other weights pay its steps, ``gentle:effort=5``, as far as terms tell it."""
        rewards, paid, failures = dict(self.rewards), dict(self.terms), list(self.facts.failures)
        for label in labels:
            name, weights = weights_of(label)
            terms = self.terms.get(name, {})
            if label not in rewards and weights and weights.keys() <= terms.keys():
                paid[label] = weighted(terms, weights)
                rewards[label] = sum_of(paid[label])
                given_up = [it for it in failures if it.column == f"{REWARD}{name}"]
                failures += [replace(it, column=f"{REWARD}{label}") for it in given_up]
        facts = replace(
            self.facts,
            rewards=tuple(dict.fromkeys([*self.facts.rewards, *rewards])),
            failures=tuple(failures),
            terms={**self.facts.terms, **{label: tuple(of) for label, of in paid.items() if label not in self.terms}},
        )
        return replace(self, rewards=rewards, terms=paid, facts=facts)


def weights_of(label: str) -> tuple[str, dict[str, float]]:
    """The reward and the weights of its terms that a label names; no weights of any other text."""
    try:
        name, params = parse(label)
        return name, {term: float(weight) for term, weight in params.items()}
    except (UsageError, ValueError):
        return label, {}


def is_recording(folder: Path) -> bool:
    """Whether a folder holds a recorded training, whole or damaged."""
    return (folder / facts_name(0)).is_file()


def recordings_in(folder: Path) -> Iterator[Path]:
    """The folders of all recorded trainings in a folder, at any depth."""
    return (path.parent for path in folder.rglob(facts_name(0)))


def read_recording(folder: Path, only: Collection[str] | None = None) -> RecordedTraining:
    """Read a recorded training, one that is still going on too: as far as it was written.

    Rewards that were written later and have paid its steps again (`harness.record.recording.scores`) are among its own.
    Where several recorders wrote it, their envs are numbered on: those of recorder 1 follow those of recorder 0.

    Args:
        folder: Of the training.
        only: Columns of rewards and measures that are read; None for all of them.

    Raises:
        SchemaError: It is damaged, is no recording, or its recorders were given different rewards.
        NewerFormat: A newer version wrote it.
    """
    with reading(folder, "recording of a training"):
        numbers = recorder_numbers(folder)
        if not numbers:
            raise SchemaError(
                f"{folder} is no recording of a training: it has no {facts_name(0)}. harness.RecordRewards makes one"
            )
        facts = [TrainingFacts.read(folder / facts_name(number)) for number in numbers]
        _require_alike(folder, numbers, facts)
        parts = sum(part_count(folder, number) for number in numbers)
        _require_few(folder, parts, len(_columns_read(facts[0], False, only)))
        tables = [read_steps(folder, number, one, only=only) for number, one in zip(numbers, facts, strict=True)]
        scores = [
            read_scores(folder / scores_name(number), len(table["time"]))
            for number, table in zip(numbers, tables, strict=True)
        ]
        if all(scores):
            facts = [one.told_in(told) for one, told in zip(scores, facts, strict=True) if one]
            tables = [{**table, **one.columns} for one, table in zip(scores, tables, strict=True) if one]
            _require_alike(folder, numbers, facts)
        return _united(facts, tables)


def recorder_numbers(folder: Path) -> list[int]:
    """Numbers of the recorders that wrote into a folder, in order."""
    if not folder.is_dir():
        return []
    numbers = sorted(int(found[1]) for path in folder.iterdir() if (found := _FACTS.fullmatch(path.name)))
    if len(numbers) > MOST_RECORDERS:
        raise SchemaError(f"{folder} has {len(numbers):,} recorders, {MOST_RECORDERS:,} are allowed")
    return numbers


def recording_files(folder: Path) -> list[str]:
    """Names of the files in a folder that a recording is read from."""
    return sorted(path.name for pattern in FILES for path in folder.glob(pattern))


def facts_name(number: int) -> str:
    """The file of a recorder's facts."""
    return f"recording-{number}.json"


def part_name(number: int, part: int) -> str:
    """The file of a part of a recorder's steps."""
    return f"{STEPS}{number}-{part:05}.parquet"


def part_schema(facts: TrainingFacts) -> pa.Schema:
    """Columns and types of a part."""
    integers = [("time", pa.int64()), *((name, pa.int32()) for name in INTEGERS)]
    numbers = [(name, pa.float64()) for name in (*facts.numbers, *facts.term_columns)]
    calls: list[tuple[str, pa.DataType]] = []
    if facts.actions is not None:
        calls = [*((name, pa.int64()) for name in CALLS), *((name, pa.float64()) for name in action_columns(facts))]
    return pa.schema([*integers, *numbers, *((name, pa.bool_()) for name in FLAGS), *calls])


def action_columns(facts: TrainingFacts) -> list[str]:
    """The columns that hold the numbers of an action; none if actions are not recorded."""
    return [f"action_{number}" for number in range(facts.actions.size if facts.actions else 0)]


def read_steps(
    folder: Path, number: int, facts: TrainingFacts, with_calls: bool = False, only: Collection[str] | None = None
) -> dict[str, NDArray[Any]]:
    """All steps of one recorder, by column.

    Args:
        folder: Of the training.
        number: Of the recorder.
        facts: What it tells of itself.
        with_calls: Whether to read the actions too, and what else a new env has to be told.
        only: Columns of rewards and measures that are read; None for all of them.

    Raises:
        SchemaError: A part is damaged or missing.
    """
    schema, names = part_schema(facts), _columns_read(facts, with_calls, only)
    count = part_count(folder, number)
    _require_few(folder, count, len(names))
    parts = [read_part(folder / part_name(number, part), schema, names) for part in range(count)]
    for part, table in enumerate(parts[:-1]):
        if len(table) != PART_ROWS:
            raise SchemaError(f"{folder / part_name(number, part)} has {len(table):,} steps, not {PART_ROWS:,}")
    whole = pa.concat_tables(parts) if parts else schema.empty_table()
    columns = {name: np.asarray(whole.column(name).to_numpy()) for name in names}
    _require_sound(folder, facts, columns)
    return columns


def _columns_read(facts: TrainingFacts, with_calls: bool, only: Collection[str] | None) -> list[str]:
    schema = part_schema(facts)
    names = schema.names if with_calls else schema.names[: schema.get_field_index(FLAGS[-1]) + 1]
    numbers = {*facts.numbers, *facts.term_columns}
    return [name for name in names if only is None or name in only or name not in numbers]


def _require_few(folder: Path, parts: int, columns: int) -> None:
    """See that all steps together find room: each part alone may be small."""
    steps = max(parts - 1, 0) * PART_ROWS  # the last one may be short
    if steps * columns > MOST_NUMBERS:
        raise SchemaError(
            f"{folder} has more than {steps:,} steps of {columns:,} columns, {MOST_NUMBERS:,} numbers are allowed"
        )


def part_count(folder: Path, number: int) -> int:
    """How many parts a recorder has written."""
    count = sum(1 for _ in folder.glob(f"{STEPS}{number}-*.parquet"))
    if count > MOST_PARTS:
        raise SchemaError(f"{folder} has {count:,} parts, {MOST_PARTS:,} are allowed")
    return count


def read_part(path: Path, schema: pa.Schema, names: Sequence[str] | None = None) -> pa.Table:
    """A part, which has the columns of `schema`; those of these names, or all of them.

    Raises:
        SchemaError: It is damaged, or has other columns.
    """
    with reading(path, "part of a recording"):
        require_regular(path, PART_BYTES)
        file = pq.ParquetFile(path, page_checksum_verification=True)
        if not file.schema_arrow.equals(schema):
            raise SchemaError(f"{path} has other columns than {facts_name(int(path.name.split('-')[1]))} tells")
        if file.metadata.num_rows > PART_ROWS:
            raise SchemaError(f"{path} has {file.metadata.num_rows:,} steps, {PART_ROWS:,} are allowed")
        require_room(file, names)
        table = file.read(names)
        if any(column.null_count for column in table.columns):
            raise SchemaError(f"{path} has gaps")
        return table


def _require_sound(folder: Path, facts: TrainingFacts, columns: Mapping[str, NDArray[Any]]) -> None:
    """Steps follow one another, of envs that are there; numbers are none but finite ones and NaN."""
    if len(columns["time"]) == 0:
        return
    time, env = columns["time"], columns["env"]
    if time[0] < 0 or (np.diff(time) < 0).any():
        raise SchemaError(f"{folder}: its steps do not stand in the order of time")
    if env.min() < 0 or env.max() >= facts.num_envs:
        raise SchemaError(f"{folder} has steps of an env beyond its {facts.num_envs}")
    if min(columns["episode"].min(), columns["step"].min()) < 0:
        raise SchemaError(f"{folder} has a step or an episode below 0")
    _require_unbroken(folder, columns)
    failed, terms = {failure.column for failure in facts.failures}, facts.term_columns
    for name in columns.keys() & {*facts.numbers, *terms}:
        if np.isinf(columns[name]).any():
            raise SchemaError(f"{folder}: {name} is infinite")
        reward = terms.get(name, name)
        if reward.startswith(REWARD) and reward not in failed and np.isnan(columns[name]).any():
            raise SchemaError(f"{folder}: {name} has no value in some steps, and no failure of it is told")


def _require_unbroken(folder: Path, columns: Mapping[str, NDArray[Any]]) -> None:
    """See that no step of an env is missing, doubled or out of place: episodes would be paid otherwise."""
    order = np.argsort(columns["env"], kind="stable")
    env, time, episode, step = (columns[name][order] for name in ("env", "time", "episode", "step"))
    is_first = np.diff(env, prepend=-1) != 0
    goes_on = (np.diff(episode) == 0) & (np.diff(step) == 1)
    begins = (np.diff(episode) > 0) & (step[1:] == 0)
    follows = (goes_on | begins) & (np.diff(time) > 0)
    wrong = np.flatnonzero(np.where(is_first, step != 0, np.append(False, ~follows)))
    if len(wrong):
        at = wrong[0]
        raise SchemaError(
            f"{folder}: step {step[at]} of episode {episode[at]} of env {env[at]} does not follow the one before it"
        )


def _require_alike(folder: Path, numbers: Sequence[int], facts: Sequence[TrainingFacts]) -> None:
    first = facts[0]
    for number, other in zip(numbers, facts, strict=True):
        if (other.numbers, other.trained_with) != (first.numbers, first.trained_with):
            raise SchemaError(
                f"{folder}: {facts_name(number)} and {facts_name(numbers[0])} tell of different rewards or measures; "
                "they are not one training"
            )


def _with_all(
    table: Mapping[str, NDArray[Any]], facts: TrainingFacts, tables: Sequence[Mapping[str, NDArray[Any]]]
) -> Mapping[str, NDArray[Any]]:
    """The columns of a recorder, and NaN for terms that only others have: it has no step yet, or paid none."""
    there = {name for name in facts.term_columns if any(name in other for other in tables)}
    return {**table, **{name: np.full(len(table["env"]), np.nan) for name in there.difference(table)}}


def _united(facts: Sequence[TrainingFacts], tables: Sequence[Mapping[str, NDArray[Any]]]) -> RecordedTraining:
    begins = np.cumsum([0, *(one.num_envs for one in facts)]).tolist()
    terms = {name: names for one in reversed(facts) for name, names in one.terms.items()}
    tables = [_with_all(table, replace(one, terms=terms), tables) for one, table in zip(facts, tables, strict=True)]
    env = np.concatenate([table["env"] + np.int32(begin) for begin, table in zip(begins, tables, strict=False)])
    columns = {name: np.concatenate([table[name] for table in tables]) for name in tables[0] if name != "env"}
    if len(tables) > 1:
        order = np.lexsort((env, columns["time"]))
        env, columns = env[order], {name: values[order] for name, values in columns.items()}
    first = facts[0]
    return RecordedTraining(
        facts=replace(
            first,
            terms=terms,
            num_envs=begins[-1],
            failures=tuple(
                replace(failure, env=failure.env + begin)
                for begin, one in zip(begins, facts, strict=False)
                for failure in one.failures
            ),
            paid_otherwise=next((one.paid_otherwise for one in facts if one.paid_otherwise), ""),
            closed=all(one.closed for one in facts),
            cut=sum(one.cut for one in facts),
        ),
        env=env,
        rewards={name: columns[f"{REWARD}{name}"] for name in first.rewards if f"{REWARD}{name}" in columns},
        behaviour={name: columns[f"{BEHAVIOUR}{name}"] for name in first.behaviour if f"{BEHAVIOUR}{name}" in columns},
        terms={
            name: {term: columns[it] for term in of if (it := term_column(name, term)) in columns}
            for name, of in terms.items()
        },
        **{name: columns[name] for name in ("time", "episode", "step", *FLAGS)},
    )
