"""Pays recorded runs again: a column of rewards per reward, in a file of its own beside the recording."""

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from harness.arrays import Float
from harness.errors import HarnessError, UsageError, reason_of
from harness.files.bounded import reading, require_regular
from harness.files.parquet import require_room
from harness.files.sums import changed_since_made, note_made
from harness.files.whole_file import whole_file
from harness.record.folder import MANIFEST
from harness.record.trace import TERM, read_trace, terms_of, to_numpy
from harness.registry.choice import Choice, choose, parse
from harness.registry.names import unknown_name
from harness.registry.registry import Registry
from harness.reward import MissingField, Paid, Reward
from harness.reward.needs import reads_of
from harness.reward.row_steps import Rows
from harness.score.recording import Chunk, Recording
from harness.score.scorer import Scorer, fields_beside_distances, joined, require_recorded
from harness.score.weights import name_of, recorded_choice, reweighted, weighted_label

MOST_BYTES = 2**35
"""Most that is read of a file of scores."""


class RecordingScorer:
    """Scores a recording chunk by chunk. Envs that trained together are runs of their own.

    Attributes:
        fields: What chunks have to have beside distances, see `harness.score.recording.Recording.chunks`.
    """

    def __init__(self, reward: Reward, there: Collection[str], *, with_all: bool = False) -> None:
        """Score nothing yet.

        Args:
            reward: The reward.
            there: The fields beside distances that the recording has.
            with_all: Whether the reward is given all of them, whatever it was seen to read.
        """
        self._reward = reward
        self._scorers: dict[int, Scorer] = {}
        self.fields = tuple(there) if with_all else fields_beside_distances(reads_of(reward, there))

    def pay(self, chunk: Chunk) -> Paid:
        """Shaped reward of the chunk's rows and its terms, (rows,)."""
        env = np.zeros(len(chunk.reward), np.int64) if chunk.env is None else chunk.env
        rows, total, terms = _rows_of(chunk), np.empty(len(env)), dict[str, Float]()
        for number in np.unique(env):
            scorer = self._scorers.setdefault(int(number), Scorer(self._reward))
            mine = env == number
            part = scorer.pay(rows if mine.all() else rows.part(mine))
            total[mine] = part.total
            for name, values in part.terms.items():
                terms.setdefault(name, np.zeros(len(env)))[mine] = values
        return Paid(total, terms)


def rescore(
    recording: Recording, rewards: Mapping[str, Reward], into: Path, weighted: Sequence[str] = ()
) -> dict[str, str]:
    """Write what each of `rewards` would have paid, a column each named by its label, a row per recorded row.

    A term of a reward has a column ``LABEL/TERM`` behind it. Columns of other rewards that `into` holds already are
    kept. The recording is not touched. A reward that raises costs its own columns.

    Args:
        recording: The run.
        rewards: By label.
        into: The file of scores.
        weighted: Rewards without their code, ``gentle:effort=0.05``: recorded columns of their terms pay, those of the
            recording, or those that `into` holds from an earlier time.

    Returns:
        By the label of each reward that cannot pay, why.

    Raises:
        UsageError: The recording has no distances, `into` belongs to another recording or cannot be written.
    """
    columns, failed = _columns_of_code(recording, rewards) if rewards else ({}, {})
    for label in weighted:
        try:
            columns |= _columns_of_terms(label, recording, into)
        except UsageError as error:
            failed[label] = str(error)
    if columns:
        _write(into, columns)
    return failed


def _columns_of_code(
    recording: Recording, rewards: Mapping[str, Reward], *, with_all: bool = False
) -> tuple[dict[str, Float], dict[str, str]]:
    """The columns of rewards that are called, and why others cannot be.

    One that reads more in some steps than in made-up ones is called again `with_all` fields.
    """
    if not recording.has_distances:
        raise UsageError(f"{recording.path} records no distances: no other reward can be computed from it")
    failed: dict[str, str] = {}
    late: dict[str, Reward] = {}
    scorers: dict[str, RecordingScorer] = {}
    for label, reward in rewards.items():
        with _noted(label, failed):
            scorer = RecordingScorer(reward, recording.fields, with_all=with_all)
            require_recorded(scorer.fields, recording.fields)
            scorers[label] = scorer
    parts: dict[str, list[Paid]] = {label: [] for label in rewards}
    for chunk in recording.chunks(fields={field for it in scorers.values() for field in it.fields}):
        for label, scorer in scorers.items():
            if label not in failed:
                with _noted(label, failed):
                    try:
                        parts[label].append(scorer.pay(chunk))
                    except MissingField:
                        late[label] = rewards[label]
                        raise
    whole = {label: joined(paid) for label, paid in parts.items() if label not in failed}
    columns = dict(column for label, paid in whole.items() for column in _columns_of(label, paid))
    if with_all or not late:
        return columns, failed
    more, still = _columns_of_code(recording, late, with_all=True)
    return {**columns, **more}, {**{label: why for label, why in failed.items() if label not in late}, **still}


def _columns_of_terms(label: str, recording: Recording, into: Path) -> dict[str, Float]:
    """The columns of a reward with other weights, from the first recorded columns of its terms that tell them."""
    refused: UsageError | None = None
    for found in recorded_terms(name_of(label), recording, into):
        try:
            return dict(_columns_of(label, reweighted(label, found.reward, found.read())))
        except UsageError as error:  # a term was recorded with the weight 0, and elsewhere perhaps with another
            refused = refused or error
    if refused is not None:
        raise refused
    trained = f" trained with {recording.declared_reward}" if recording.taught_by else ""
    raise UsageError(
        f"a run{trained} has no columns of the terms of '{name_of(label)}': give its file, --plugin FILE, and it is "
        "called"
    )


class RecordedTerms(NamedTuple):
    """Columns of the terms of a reward."""

    reward: Choice
    """The reward, with the weights that it was recorded with."""
    terms: tuple[str, ...]
    read: Callable[[], dict[str, Float]]
    """A function that reads them, by term, (rows,) each."""


def recorded_terms(name: str, recording: Recording, into: Path) -> Iterator[RecordedTerms]:
    """What is recorded of the terms of rewards of a name: by the run itself, then by a file of scores beside it."""
    reward, terms = recording.taught_by, recording.terms
    if reward is not None and terms and reward.name == name:
        columns = [f"{TERM}{term}" for term in terms]
        yield RecordedTerms(reward, terms, lambda: terms_of(read_trace(recording.path, columns)))
    if not into.exists() or into.name in changed_since_made(into.parent):
        return
    with reading(into, "file of scores", UsageError):
        require_regular(into, MOST_BYTES)
        names = pq.read_schema(into).names
    for label in (it for it in names if name_of(it) == name):
        begin = f"{label}/"
        terms = tuple(it.removeprefix(begin) for it in names if it.startswith(begin) and "/" not in it[len(begin) :])
        if terms:
            yield RecordedTerms(recorded_choice(label), terms, partial(_read_terms, into, begin, terms))


def _read_terms(scores: Path, begin: str, terms: Sequence[str]) -> dict[str, Float]:
    with reading(scores, "file of scores", UsageError):
        table = pq.read_table(scores, columns=[f"{begin}{term}" for term in terms])
        return {term: to_numpy(table.column(f"{begin}{term}"), f"{scores}: {begin}{term}") for term in terms}


def scoring_choice(text: str, registry: Registry, places: Iterable[tuple[Recording, Path]]) -> Choice:
    """The reward that a user named; of one that is not installed, its name and its weights, if its terms are recorded.

    Args:
        text: What the user typed, ``gentle:effort=0.05``.
        registry: The plugins.
        places: The runs, each with the file that its scores are written into.

    Raises:
        UsageError: It is neither installed nor recorded, or it is malformed.
    """
    name = parse(text)[0]
    if is_installed(registry, name):
        return choose(registry, "rewards", text)
    known: dict[str, None] = {}
    for recording, into in places:
        if found := next(recorded_terms(name, recording, into), None):
            return recorded_choice(weighted_label(text, found.terms))
        if recording.taught_by and recording.terms:
            known[recording.taught_by.name] = None
    if known:
        raise UsageError(unknown_name("reward", name, [*registry.names("rewards"), *known]))
    return choose(registry, "rewards", text)  # which says that there is none


def is_installed(registry: Registry, reward: str) -> bool:
    """Whether there is code for a reward of this name."""
    return "rewards" in registry.kinds_of(reward)


def write_scores(recording: Recording, scoring: Iterable[Choice], into: Path, registry: Registry) -> dict[str, str]:
    """See `rescore`; rewards that are not installed are paid from columns."""
    built, failed, weighted = dict[str, Reward](), dict[str, str](), list[str]()
    for choice in scoring:
        if not is_installed(registry, choice.name):
            weighted.append(choice.label)
            continue
        try:
            built[choice.label] = choice.build(registry, "rewards")
        except HarnessError as error:
            failed[choice.label] = str(error)
    return {**failed, **rescore(recording, built, into, weighted)}


@contextmanager
def _noted(label: str, failed: dict[str, str]) -> Iterator[None]:
    """Whatever a reward raises is written down under its label: a plugin may raise anything."""
    try:
        yield
    except (Exception, SystemExit) as error:
        failed[label] = reason_of(error)


def _columns_of(label: str, paid: Paid) -> Iterator[tuple[str, Float]]:
    yield label, paid.total
    yield from ((f"{label}/{name}", values) for name, values in paid.terms.items())


def _write(into: Path, columns: Mapping[str, Float]) -> None:
    kept: dict[str, pa.ChunkedArray] = {}
    rows = len(next(iter(columns.values())))
    if into.exists() and into.name not in changed_since_made(into.parent):
        with reading(into, "file of scores", UsageError):
            kept = _earlier(into, rows)
    try:
        into.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(into) as partial:
            pq.write_table(pa.table({**kept, **columns}), partial, compression="zstd")
        if (into.parent / MANIFEST).exists():
            note_made(into)  # behind the manifest, which names what the cell itself left
    except OSError as error:
        raise UsageError(f"'{into}' cannot be written: {error.strerror}. Name another folder with --out") from None


def _earlier(path: Path, rows: int) -> dict[str, pa.ChunkedArray]:
    require_regular(path, MOST_BYTES)
    file = pq.ParquetFile(path)
    if file.metadata.num_rows != rows:
        raise UsageError(f"{path} has {file.metadata.num_rows} rows, the recording {rows}: it belongs to another one")
    require_room(file)
    table = file.read()
    return dict(zip(table.column_names, table.columns, strict=True))


def _rows_of(chunk: Chunk) -> Rows:
    """The rows of a chunk of a recording that has distances."""
    return Rows(chunk.start, chunk.begin_distance, chunk.previous_best, chunk.distance, chunk.touched, chunk.more)  # type: ignore[arg-type]
