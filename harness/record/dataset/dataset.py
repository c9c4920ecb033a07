"""What a data set of either format looks like to whatever reads it."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float
from harness.errors import SchemaError
from harness.text import shortened

Nested: TypeAlias = Any
"""Rows of an observation or an action: an array (rows, ...), or a dict or a tuple of `Nested`."""

ROWS = 16_384
"""The most steps of a piece."""
PIECE_BYTES = 2**25
"""The most bytes of the numbers of a piece, 32 MiB; wide observations come in pieces of fewer steps."""
MOST_STEPS, MOST_EPISODES = 100_000_000, 2_000_000
MOST_NUMBERS = 16_384
"""The most numbers of one observation, or of one action: pictures are left out."""
MOST_KEYS = 1_000
"""The most columns, or parts of an observation; of an episode's parts all together."""
MOST_VALUES = 20_000_000_000
"""The most numbers that are read of a data set: steps times the numbers of each."""
RECORDED = "recorded"
"""The name of the reward that the data set's own column of rewards holds."""
SUCCESS_KEYS = ("success", "is_success")
"""What a column may be called that says whether a step was a success."""
OPERATOR_KEYS = ("operator", "operator_id")
"""What may be called who, or what, made an episode."""
OWN_REWARDS = "harness_rewards"
"""The key of the metadata under which `harness export` lists the rewards that it wrote, by column."""
NOTHING_SEEN = "recorded pay is read, and functions that look at no observation"
"""What is left of a data set whose observations hold no numbers."""
LARGEST = 1e150
"""The largest number, whose square is still finite."""


@dataclass(frozen=True)
class DatasetFacts:
    """What is known of a data set beside its steps.

    Attributes:
        name: As the user named it, ``minari:D4RL/pen/human-v2``.
        path: Its folder.
        format: Format and version, in words.
        env: The specification of the env that its metadata tells, as text; empty if it tells none. It is never run.
        names: By column, ``observation`` and ``action``, what its numbers are called, as far as the metadata says.
        rewards: Names of the rewards that are recorded; `RECORDED` is the data set's own.
        success: What says whether a step, or an episode, was a success; empty if nothing does.
        operator: What says who made an episode; empty if nothing does.
        task: What says which task an episode does; empty if nothing does.
        declared_tasks: How many tasks the metadata says that there are; None if it does not.
        pictures_left_out: Whether something that was seen is left out, such as pictures.
        notes: What to keep in mind, a line each.
    """

    name: str
    path: Path
    format: str
    env: str = ""
    names: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    rewards: tuple[str, ...] = ()
    success: str = ""
    operator: str = ""
    task: str = ""
    declared_tasks: int | None = None
    pictures_left_out: bool = False
    notes: tuple[str, ...] = ()


@dataclass(frozen=True, eq=False)
class Piece:
    """Consecutive steps of one episode.

    Attributes:
        episode: Its number in the data set.
        first: Number of the first step in the episode, counted from 0.
        observations: Before each step, and after the last: `Nested` of steps + 1 rows; of as many rows as steps where
            nothing is known of what came after the last.
        actions: `Nested` of as many rows as steps.
        infos: By key, what was told after each step, (steps, ...).
        rewards: By name, what was recorded, (steps,).
        told: Whether each step was a success, `SUCCESS`, `FAILURE` or `UNKNOWN` of `labels`, (steps,). What holds for a
            whole episode stands in its last step.
        operator: Who, or what, made the episode; empty if nothing says it.
        task: Which task it does; empty if nothing says it.
        file: Where the episode lies, in the data set's folder.
        is_last: Whether the episode ends with this piece.
        flaw: Why the episode cannot be used, such as a number that is not finite; empty if it can.
    """

    episode: int
    first: int
    observations: Nested
    actions: Nested
    infos: Mapping[str, NDArray[Any]]
    rewards: Mapping[str, Float]
    told: NDArray[np.int8]
    operator: str
    task: str
    file: str
    is_last: bool
    flaw: str = ""

    def __len__(self) -> int:
        return row_count(self.actions)

    @property
    def seen(self) -> int:
        """How many steps it is known of what was seen after them: all, or all but the last."""
        return row_count(self.observations) - 1


@dataclass(frozen=True)
class Dataset:
    """A data set whose steps are read later.

    Attributes:
        facts: What is known of it.
    """

    facts: DatasetFacts
    _pieces: Callable[[], Iterator[Piece]]

    def pieces(self) -> Iterator[Piece]:
        """All steps, episode after episode, in order.

        Raises:
            SchemaError: It is damaged, or has more than is allowed.
        """
        steps = episodes = 0
        for piece in self._pieces():
            steps, episodes = steps + len(piece), episodes + (piece.first == 0)
            if steps > MOST_STEPS or episodes > MOST_EPISODES:
                raise SchemaError(
                    f"{self.facts.path} has more than {MOST_STEPS:,} steps or {MOST_EPISODES:,} episodes, which is "
                    "not allowed"
                )
            yield piece
        if not steps:
            raise SchemaError(f"{self.facts.path} has no step")


def row_count(rows: Nested) -> int:
    """How many rows there are.

    Raises:
        ValueError: There is no part, or the parts have different numbers of rows.
    """
    counts = {len(part) for part in leaves(rows)}
    if len(counts) != 1:
        raise ValueError("its parts have different numbers of rows" if counts else "it has no part that is read")
    return counts.pop()


def leaves(rows: Nested) -> Iterator[NDArray[Any]]:
    """All arrays in it."""
    if isinstance(rows, dict | tuple):
        for part in rows.values() if isinstance(rows, dict) else rows:
            yield from leaves(part)
    else:
        yield rows


def take_rows(rows: Nested, which: slice | int) -> Nested:
    """Some rows, or one."""
    if isinstance(rows, dict):
        return {key: take_rows(part, which) for key, part in rows.items()}
    if isinstance(rows, tuple):
        return tuple(take_rows(part, which) for part in rows)
    return rows[which]


def each_row(rows: Nested) -> Iterator[Nested]:
    """One row after the other."""
    if isinstance(rows, np.ndarray):
        return iter(rows)
    return (take_rows(rows, row) for row in range(row_count(rows)))


def flaw_of(rows: Nested, noun: str) -> str:
    """Why numbers cannot be counted with: one is not finite, or too large; empty if they can.

    Raises:
        SchemaError: They are no numbers.
    """
    for values in leaves(rows):
        if values.dtype.kind not in "biuf":
            raise SchemaError(f"{noun} holds {values.dtype}, no numbers")
        largest = LARGEST if values.dtype.itemsize >= 8 else np.inf
        if values.dtype.kind == "f" and not (np.isfinite(values) & (np.abs(values) <= largest)).all():
            return f"{noun} holds a value that is not a finite number, or one beyond {LARGEST:g}"
    return ""


def own_rewards(path: Path, told: Any, known: Mapping[str, Any], taken: tuple[str, ...] = ()) -> dict[str, str]:
    """By column, the names of rewards that `harness export` wrote.

    Args:
        path: What a message names.
        told: What the metadata has under `OWN_REWARDS`.
        known: The columns that there are.
        taken: Columns that mean something else.

    Raises:
        SchemaError: Two columns have one name, one is called what the data set's own reward is, or it means something
            else.
    """
    own = told if isinstance(told, dict) else {}
    own = {key: shortened(name, 200) for key, name in own.items() if key in known and isinstance(name, str)}
    for key, name in own.items():
        if name == RECORDED or key in taken or list(own.values()).count(name) > 1:
            raise SchemaError(
                f"{path}: {OWN_REWARDS} calls {shortened(key, 80)} '{name}', but that name, or that column, is another "
                "reward's or no reward's"
            )
    return own


def require_readable(path: Path, steps: int, width: int) -> None:
    """Bounds on what is read, before any of it is.

    Raises:
        SchemaError: So many steps of so many numbers are too much.
    """
    if steps > MOST_STEPS:
        raise SchemaError(f"{path} has more than {MOST_STEPS:,} steps, which is not allowed")
    if steps * width > MOST_VALUES:
        raise SchemaError(f"{path} has {steps * width:,} numbers, {MOST_VALUES:,} are allowed")
