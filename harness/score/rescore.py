"""Pays recorded runs again: a column of rewards per reward, in a file of its own beside the recording."""

from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq

from harness.arrays import Float
from harness.errors import UsageError, reason_of
from harness.files.bounded import changed_since_made, note_made, reading, whole_file
from harness.files.parquet import open_parquet, require_room
from harness.log import Log
from harness.log.log import REWARD, START
from harness.record.cell_log import cell_of
from harness.record.folder import MANIFEST
from harness.registry.choice import Choice, Registry, choose, parse
from harness.registry.spec import unknown_name
from harness.score.installed_reward import InstalledReward, is_installed
from harness.score.scorer import SCORED, can_be_paid
from harness.score.weights import label_by_terms, name_of, recorded_choice

MOST_BYTES = 2**35
"""Most that is read of a file of scores."""


def rescore(log: Log, scoring: Collection[Choice], into: Path, registry: Registry) -> dict[str, str]:
    """Write what each reward would have paid, a column each named by its label, a row for each row of the log.

    A term of a reward has a column ``LABEL/TERM`` behind it. Columns of other rewards that `into` holds already are
    kept. The recording is not touched. A reward that raises costs its own columns. One that is not installed is paid
    from recorded columns of its terms.

    Args:
        log: The run.
        scoring: The rewards.
        into: The file of scores.
        registry: The plugins.

    Returns:
        By the label of each reward that cannot pay, why.

    Raises:
        UsageError: The recording has no distances, `into` belongs to another recording or cannot be written.
    """
    if not can_be_paid(log) and any(is_installed(registry, choice.name) for choice in scoring):
        raise UsageError(f"{log.facts.path} records no distances: no other reward can be computed from it")
    cell, columns, failed = cell_of(log.facts.path), dict[str, Float](), dict[str, str]()
    told = (cell.reward, f"{REWARD}{cell.reward.label}/") if cell else (None,)
    for choice in scoring:
        label = choice.label
        try:
            paid = InstalledReward(choice, registry).paid(log.load((*SCORED, START)), *told)
        except (Exception, SystemExit) as error:  # a plugin may raise anything
            failed[label] = reason_of(error)
        else:
            columns |= {label: paid.total, **{f"{label}/{name}": values for name, values in paid.terms.items()}}
    if columns:
        write_scores(into, _kept(into, len(next(iter(columns.values())))) | columns)
    return failed


def scoring_choice(text: str, registry: Registry, logs: Iterable[Log]) -> Choice:
    """The reward that a user named; of one that is not installed, its name and its weights, if its terms are recorded.

    Args:
        text: What the user typed, ``gentle:effort=0.05``.
        registry: The plugins.
        logs: The runs.

    Raises:
        UsageError: It is neither installed nor recorded, or it is malformed.
    """
    name = parse(text)[0]
    cells = () if is_installed(registry, name) else ((cell_of(log.facts.path), log) for log in logs)
    known = {it.reward.label: of for it, log in cells if it and (of := log.terms_of(it.reward.label))}
    if label := label_by_terms(text, known.items()):
        return recorded_choice(label)
    if known:
        names = dict.fromkeys((*registry.names("rewards"), *map(name_of, known)))
        raise UsageError(unknown_name("reward", name, names))
    return choose(registry, "rewards", text)  # which says that there is none


def _kept(into: Path, rows: int) -> dict[str, Any]:
    """The columns that a file of scores holds already."""
    if not into.exists() or into.name in changed_since_made(into.parent):
        return {}
    with reading(into, "file of scores", UsageError):
        file = open_parquet(into, MOST_BYTES)
        if file.metadata.num_rows != rows:
            told = f"{into} has {file.metadata.num_rows} rows, the recording {rows}: it belongs to another one"
            raise UsageError(told)
        require_room(into, file)
        table = file.read()
        return dict(zip(table.column_names, table.columns, strict=True))


def write_scores(into: Path, columns: Mapping[str, Any]) -> None:
    """Write what rewards pay each row, (rows,), and nothing else.

    Raises:
        UsageError: The file cannot be written.
    """
    try:
        into.parent.mkdir(parents=True, exist_ok=True)
        with whole_file(into) as partial:
            pq.write_table(pa.table(dict(columns)), partial, compression="zstd")
        if (into.parent / MANIFEST).exists():
            note_made(into)  # behind the manifest, which names what the cell itself left
    except OSError as error:
        raise UsageError(f"'{into}' cannot be written: {error.strerror}. Name another folder with --out") from None
