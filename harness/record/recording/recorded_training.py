"""Reads the folder of a recorded training as a log.

Its steps have one more column than others: ``tick`` is how often the step's recorder had been stepped before, which
rows of one batch share. Where actions are recorded and can be taken again it also has `CALLS`.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa

from harness.errors import SchemaError
from harness.files.bounded import making, reading
from harness.files.parquet import MOST_NUMBERS, require_room
from harness.log import Log
from harness.log.log import REWARD, TIME, Columns, Rows, joined
from harness.record.folder import part_path
from harness.record.parts import PART_ROWS, open_part, rows_of
from harness.record.recording.facts import TrainingFacts, facts_of, file_column, log_column
from harness.record.recording.scores import read_scores, scores_name, with_scores, write_scores
from harness.reward.steps import ENDS

MOST_PARTS, MOST_RECORDERS = 100_000, 10_000
"""Most that is read of a recording."""

TICK, ACTION = "tick", "action"
TICK_IN_FILE = "time"
INTEGERS = ("env", "episode", "step")
ANSWER = "answer"
CALLS = ("seed", "resets", ANSWER)
"""The columns of a step whose action is recorded; `harness.recorder.recorder.Calls` says what they are."""
STEPS = "steps-"
"""What the names of the parts begin with."""
PART = "part of a recording"

FILES = ("recording-*.json", f"{STEPS}*.parquet", "scores-*.parquet")
"""Patterns of the files that a recording is read from."""
_FACTS = re.compile(r"recording-(0|[1-9]\d{0,5})\.json")


def is_recording(folder: Path) -> bool:
    """Whether a folder holds a recorded training, whole or damaged."""
    return (folder / facts_name(0)).is_file()


def recordings_in(folder: Path) -> Iterator[Path]:
    """The folders of all recorded trainings in a folder, at any depth."""
    return (path.parent for path in folder.rglob(facts_name(0)))


def read_recording(folder: Path) -> Log:
    """The log of a recorded training, one that is still going on too: as far as it was written.

    Rewards that were written later and have paid its steps again (`harness.record.recording.scores`) are among its own.
    Where several recorders wrote it, their envs are numbered on: those of recorder 1 follow those of recorder 0. Each
    pass over its rows raises SchemaError where steps are damaged or missing.

    Args:
        folder: Of the training.

    Raises:
        SchemaError: Its facts or scores are damaged, it is no recording, or its recorders were given different rewards.
        NewerFormat: A newer version wrote it.
    """
    with reading(folder, "recording of a training"):
        numbers = recorder_numbers(folder)
        if not numbers:
            raise SchemaError(
                f"{folder} is no recording of a training: it has no {facts_name(0)}. harness.RecordRewards makes one"
            )
        read = [read_scored(folder, number) for number in numbers]
        are_scored = all(later is not None for _, later in read)
        logs = [with_scores(log, later if are_scored else None) for log, later in read]
        told = [(facts.numbers, facts.trained_with) for facts in map(facts_of, logs)]
        for number, of in zip(numbers, told, strict=True):
            if of != told[0]:
                raise SchemaError(
                    f"{folder}: {facts_name(number)} and {facts_name(numbers[0])} tell of different rewards or "
                    "measures; they are not one training"
                )
        return logs[0] if len(logs) == 1 else united(logs)


def read_scored(folder: Path, number: int) -> tuple[Log, Log | None]:
    """The log of one recorder's steps, and what of it was scored later; None of one that went on since.

    Raises:
        SchemaError: Its facts or scores are damaged.
        NewerFormat: A newer version wrote them.
    """
    log, path = read_recorder(folder, number), folder / scores_name(number)
    return log, read_scores(path, step_count(folder, number)) if path.exists() else None


def add_scores(folder: Path, scores: Mapping[int, Log]) -> None:
    """Write what was scored later of the steps of recorders, by their numbers, beside what was scored before.

    Raises:
        SchemaError: The scores that are there are damaged.
        OSError: The folder cannot be written.
    """
    found = {}
    for number, later in scores.items():
        _, earlier = read_scored(folder, number)
        found[folder / scores_name(number)] = later if earlier is None else with_scores(earlier, later)
    for path, whole in found.items():
        with making(path):
            write_scores(path, whole)


def read_recorder(folder: Path, number: int, after: int = 0) -> Log:
    """The log of one recorder's steps, without what was scored later.

    Args:
        folder: Of the training.
        number: Of the recorder.
        after: Leave out so many of its parts, which are full and were read before.

    Raises:
        SchemaError: Its facts are damaged.
        NewerFormat: A newer version wrote it.
    """
    facts = read_facts(folder, number)
    part_paths(folder, number)
    names = _names(facts, with_calls=facts.actions is not None and not facts.actions.problem)
    if len({*names}) < len(names):
        raise SchemaError(f"{folder}: a reward and the term of another one have the same column")
    return Log(facts, names, partial(_tables, folder, number, facts, after))


def _names(facts: TrainingFacts, *, with_calls: bool) -> tuple[str, ...]:
    calls = (*CALLS, ACTION) if with_calls else ()
    return (TIME, TICK, *INTEGERS, *facts.numbers, *facts.term_columns, *ENDS, *calls)


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


def read_facts(folder: Path, number: int = 0) -> TrainingFacts:
    """The facts of a recorder.

    Raises:
        SchemaError: They are damaged, or not there.
        NewerFormat: A newer version wrote them.
    """
    return TrainingFacts.read(folder / facts_name(number))


def facts_name(number: int) -> str:
    """The file of a recorder's facts."""
    return f"recording-{number}.json"


def first_part(folder: Path, number: int) -> Path:
    """The first of the files of a recorder's steps; see `harness.record.folder.part_path`."""
    return folder / f"{STEPS}{number}-00000.parquet"


def part_schema(facts: TrainingFacts) -> pa.Schema:
    """Columns and types of a part."""
    return pa.schema({
        TICK_IN_FILE: pa.int64(),
        **dict.fromkeys(INTEGERS, pa.int32()),
        **dict.fromkeys((*map(file_column, facts.numbers), *facts.term_columns), pa.float64()),
        **dict.fromkeys(ENDS, pa.bool_()),
        **dict.fromkeys(CALLS if facts.actions else (), pa.int64()),
        **dict.fromkeys(action_columns(facts), pa.float64()),
    })  # fmt: skip


def action_columns(facts: TrainingFacts) -> list[str]:
    """The columns that hold the numbers of an action; none if actions are not recorded."""
    return [f"action_{number}" for number in range(facts.actions.size if facts.actions else 0)]


def part_paths(folder: Path, number: int) -> list[Path]:
    """The files of a recorder's steps, in order: as many as there are."""
    count = sum(1 for _ in folder.glob(f"{STEPS}{number}-*.parquet"))
    if count > MOST_PARTS:
        raise SchemaError(f"{folder} has {count:,} parts, {MOST_PARTS:,} are allowed")
    return [part_path(first_part(folder, number), part) for part in range(count)]


def step_count(folder: Path, number: int) -> int:
    """How many steps a recorder has written, by its last part.

    Raises:
        SchemaError: That part is damaged.
    """
    paths = part_paths(folder, number)
    if not paths:
        return 0
    with open_part(paths[-1], PART) as file:
        return (len(paths) - 1) * PART_ROWS + int(file.metadata.num_rows)


def _tables(folder: Path, number: int, facts: TrainingFacts, after: int, names: tuple[str, ...]) -> Iterator[Columns]:
    """The parts of a recorder, these columns of them, as soon as its steps were found to follow one another."""
    schema, paths, actions = part_schema(facts), part_paths(folder, number), action_columns(facts)
    own = {name: TICK if name == TICK_IN_FILE else log_column(name) for name in schema.names}
    wanted = {*INTEGERS, TICK, *names, *(actions if ACTION in names else ())}
    columns = [name for name, called in own.items() if called in wanted]
    last: Columns | None = None if after else dict.fromkeys((*INTEGERS, TICK), np.empty(0, np.int64))
    taken = after * PART_ROWS
    for path in paths[after:]:
        with open_part(path, PART) as file:
            if not file.schema_arrow.equals(schema):
                raise SchemaError(f"{path} has other columns than {facts_name(number)} tells")
            count, is_last = file.metadata.num_rows, path == paths[-1]
            if count > PART_ROWS or not (is_last or count == PART_ROWS):
                raise SchemaError(f"{path} has {count:,} steps, not {PART_ROWS:,}{' or fewer' * is_last}")
            require_room(path, file, columns, MOST_NUMBERS // len(paths))  # each alone may be small
            rows = joined([*rows_of(file, path, columns)])
        told = {own[name]: values for name, values in rows.items()}
        last = _require_sound(folder, facts, told, last)
        if ACTION in names and facts.actions:
            told[ACTION] = np.stack([told[name] for name in actions], axis=1).reshape(-1, *facts.actions.shape)
        told[TIME] = np.arange(taken + 1, taken + count + 1)
        taken += count
        yield {name: told[name] for name in names}


def _require_sound(folder: Path, facts: TrainingFacts, columns: Columns, last: Columns | None) -> Columns | None:
    """See that the steps of a part follow those before it, of envs that are there; numbers are finite ones or NaN.

    Args:
        folder: Of the training.
        facts: What is known of it.
        columns: Of the part.
        last: What this returned of the part before; no rows at the first one, None where that is not known.

    Returns:
        The last step of each env so far.
    """
    time, env = columns[TICK], columns["env"]
    if not len(time):
        return last
    if (np.diff(time, prepend=last[TICK].max(initial=0) if last else 0) < 0).any():
        raise SchemaError(f"{folder}: its steps do not stand in the order of time")
    if env.min() < 0 or env.max() >= facts.num_envs:
        raise SchemaError(f"{folder} has steps of an env beyond its {facts.num_envs}")
    if min(columns["episode"].min(), columns["step"].min()) < 0:
        raise SchemaError(f"{folder} has a step or an episode below 0")
    ends = _require_unbroken(folder, columns, last)
    failed, terms = {failure.column for failure in facts.failed}, facts.term_columns
    for name in sorted(columns.keys() & {*facts.numbers, *terms}):
        if np.isinf(columns[name]).any():
            raise SchemaError(f"{folder}: {name} is infinite")
        reward = terms.get(name, name)
        if reward.startswith(REWARD) and reward not in failed and np.isnan(columns[name]).any():
            raise SchemaError(f"{folder}: {name} has no value in some steps, and no failure of it is told")
    return ends


def _require_unbroken(folder: Path, columns: Columns, last: Columns | None) -> Columns:
    """See that no step of an env is missing, doubled or out of place: episodes would be paid otherwise."""
    names = ("env", TICK, "episode", "step")
    rows = {name: np.concatenate([last[name], columns[name]]) if last else columns[name] for name in names}
    order = np.argsort(rows["env"], kind="stable")
    env, time, episode, step = (rows[name][order] for name in names)
    is_first = np.diff(env, prepend=-1) != 0
    before = len(last["env"]) if last else len(env)
    is_known = order < before  # a step of an earlier part, the first one of its env here
    goes_on = (np.diff(episode) == 0) & (np.diff(step) == 1)
    begins = (np.diff(episode) > 0) & (step[1:] == 0)
    follows = (goes_on | begins) & (np.diff(time) > 0)
    wrong = np.flatnonzero(np.where(is_first, ~is_known & (step != 0), np.append(False, ~follows)))
    if len(wrong):
        at = wrong[0]
        raise SchemaError(
            f"{folder}: step {step[at]} of episode {episode[at]} of env {env[at]} does not follow the one before it"
        )
    is_last = np.append(is_first[1:], True)
    return {name: rows[name][order][is_last] for name in names}


def united(logs: Sequence[Log]) -> Log:
    """The logs of several recorders of one training as one, its rows in the order of time and of their envs."""
    facts = [facts_of(log) for log in logs]
    first, begins = facts[0], np.cumsum([0, *(one.num_envs for one in facts)]).tolist()
    whole = replace(
        first,
        terms={name: names for one in reversed(facts) for name, names in one.terms.items()},
        num_envs=begins[-1],
        failed=tuple(
            replace(failure, env=failure.env + begin)
            for begin, one in zip(begins, facts, strict=False)
            for failure in one.failures
        ),
        paid_otherwise=next((one.paid_otherwise for one in facts if one.paid_otherwise), ""),
        closed=all(one.closed for one in facts),
        cut=sum(one.cut for one in facts),
    )
    with_calls = all(ACTION in log and one.actions == first.actions for log, one in zip(logs, facts, strict=True))
    return Log(whole, _names(whole, with_calls=with_calls), partial(_sorted, logs, begins))


def _sorted(logs: Sequence[Log], begins: Sequence[int], names: tuple[str, ...]) -> Iterator[Columns]:
    """Their rows in the order of time, those of a moment by env; NaN in rows of a recorder that lacks a term."""
    asked = tuple(dict.fromkeys(name for name in (TICK, "env", *names) if name != TIME))
    tables = list[Columns]()
    for log, begin in zip(logs, begins, strict=False):
        told = log.rows(name for name in asked if name in log)
        rows = {name: told[name] if name in log else np.full(len(told), np.nan) for name in asked}
        tables += [{**rows, "env": rows["env"] + np.int32(begin)}] if len(told) else []
    if tables:
        whole = Rows(joined(tables))
        ordered = whole.part(np.lexsort((whole["env"], whole[TICK]))).columns
        found = {**ordered, TIME: np.arange(1, len(whole) + 1)}
        yield {name: found[name] for name in names}
