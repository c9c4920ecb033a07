"""The steps of a data set, an episode after the other, and what a reward is given of them."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from harness.arrays import Float, Ints, Mask
from harness.errors import SchemaError
from harness.log import Log, Rows
from harness.log.log import ACTION, BEFORE, INFO, OBSERVATION, SEEN, Array, is_countable
from harness.reward import Paid

if TYPE_CHECKING:
    from harness.score.places import ArmPlaces

Nested: TypeAlias = Any
"""Rows of an observation or an action: an array (rows, ...), or a dict or a tuple of `Nested`."""
Payer: TypeAlias = Callable[[Rows], Paid]
"""What a reward pays some steps of one episode, (steps,), and its terms. It is given all steps in their order.

One that needs what was seen after a step leaves out the last one, where nothing is known of that.
"""
INDEX = "_index_"
"""How the parts of a tuple are called: this and their number."""
VECTORS = (f"{BEFORE}{OBSERVATION}", OBSERVATION, ACTION)


def parts_of(rows: Rows, name: str) -> list[Array]:
    """The columns of an observation or an action, or of its parts: ``observation/goal`` of ``observation``."""
    return [values for column, values in rows.columns.items() if column == name or column.startswith(f"{name}/")]


def steps_by_episode(log: Log, columns: Iterable[str]) -> Iterator[Rows]:
    """All steps in order, never those of two episodes together; a long episode comes in several parts.

    Raises:
        SchemaError: The log is damaged, or steps of an episode stand in two places.
    """
    begun: set[int] = set()
    number = -1
    for table in log.tables(columns):
        episode = table["episode"]
        if not len(episode):
            continue
        for first, end in pairwise([0, *(np.flatnonzero(np.diff(episode)) + 1).tolist(), len(episode)]):
            begins, number = episode[first] != number, int(episode[first])
            if begins and number in begun:
                raise SchemaError(f"{log.facts.path}: the steps of episode {number} stand in two places")
            begun.add(number)
            yield table.part(slice(first, end))


def seen_after(rows: Rows) -> int:
    """How many steps, of one episode, it is known of what was seen after them: all, or all but the last."""
    return int(rows[SEEN].sum()) if SEEN in rows.columns else len(rows)


def readable(rows: Rows, name: str) -> Mask:
    """In which steps all numbers of an observation or an action are finite and not too large, (rows,).

    Raises:
        SchemaError: They are no numbers.
    """
    fits = np.ones(len(rows), bool)
    for values in parts_of(rows, name):
        if values.dtype.kind not in "biuf":
            raise SchemaError(f"{name} holds {values.dtype}, no numbers")
        if values.dtype.kind == "f":
            fits &= is_countable(values).reshape(len(rows), -1).all(axis=1)
    return fits


def vectors_of(columns: Mapping[str, Array], name: str) -> Nested:
    """An observation or an action as a reward is given it, from the columns of its parts.

    Returns:
        An array, or a dict, or a tuple where its parts are numbered; an empty dict if there is none.
    """
    if name in columns:
        return columns[name]
    parts: dict[str, Any] = {}
    for column, values in columns.items():
        if column.startswith(f"{name}/"):
            *groups, last = column.removeprefix(f"{name}/").split("/")
            place = parts
            for group in groups:
                place = place.setdefault(group, {})
            place[last] = values
    return _with_tuples(parts)


def _with_tuples(parts: Any) -> Nested:
    if not isinstance(parts, dict):
        return parts
    made = {key: _with_tuples(part) for key, part in parts.items()}
    numbered = [f"{INDEX}{number}" for number in range(len(made))]
    return tuple(made[key] for key in numbered) if made and all(key in made for key in numbered) else made


def infos_of(columns: Mapping[str, Array]) -> dict[str, Array]:
    """What was told after each step, by key; without what was not told in any of these steps."""
    found = {name.removeprefix(INFO): values for name, values in columns.items() if name.startswith(INFO)}
    return {key: it for key, it in found.items() if it.dtype.kind != "f" or not np.isnan(it).all()}


def each_row(rows: Nested, count: int) -> Iterator[Nested]:
    """One row after the other."""
    if isinstance(rows, np.ndarray):
        return iter(rows[:count])
    return (_row(rows, row) for row in range(count))


def _row(rows: Nested, row: int) -> Nested:
    if isinstance(rows, dict):
        return {key: _row(part, row) for key, part in rows.items()}
    return tuple(_row(part, row) for part in rows) if isinstance(rows, tuple) else rows[row]


def flat_rows(rows: Rows, name: str) -> Float:
    """All numbers of each observation or action, (rows, numbers)."""
    flat = [np.asarray(part, np.float64).reshape(len(part), -1) for part in parts_of(rows, name)]
    return np.concatenate(flat, axis=1) if flat else np.empty((len(rows), 0))


LEARNT = 4_096
"""After so many steps it is known how much a number of an observation changes in a step."""


class Movement:
    """How far each step moves: the mean over the numbers of an observation, each by how much it changes in a step.

    Observations of another size, in the env of another task, have a scale of their own.
    """

    def __init__(self, places: "ArmPlaces | None") -> None:
        self._places = places
        self._waiting = defaultdict[int, list[tuple[Float, Ints, Float]]](list)
        self._scale: dict[int, Float] = {}
        self._moved: list[Float] = []

    def take(self, rows: Rows, seen: int) -> None:
        """The next steps of one episode, of which it is known what was seen after the first `seen`."""
        moved = np.full(len(rows), np.nan)
        self._moved.append(moved)
        if not seen:
            return
        before, after = (self._positions(rows, name) for name in VECTORS[:2])
        with np.errstate(all="ignore"):  # what is not finite did not move
            change = np.abs(after[:seen] - before[:seen])
        moved[:seen], width = np.inf, change.shape[1]
        if not width:
            return
        where = np.flatnonzero(is_countable(change).all(axis=1))
        change = change[where]
        if width in self._scale:
            moved[where] = self._far(change)
        else:
            self._waiting[width].append((moved, where, change))
            if sum(len(told) for _, told, _ in self._waiting[width]) >= LEARNT:
                self._learn(width)

    def end(self) -> Float:
        """How far each step moved, (steps,); see `PaidDataset.moved`."""
        for width in tuple(self._waiting):
            self._learn(width)
        return np.concatenate(self._moved)

    def _positions(self, rows: Rows, name: str) -> Float:
        if self._places is None:
            return flat_rows(rows, name)
        return self._places.end_effector(vectors_of(rows.columns, name))

    def _learn(self, width: int) -> None:
        waiting = self._waiting.pop(width)
        changes = np.concatenate([change for *_, change in waiting])
        self._scale[width] = np.sqrt(np.square(changes).sum(axis=0) / max(len(changes), 1))
        for moved, where, change in waiting:
            moved[where] = self._far(change)

    def _far(self, change: Float) -> Float:
        scale = self._scale[change.shape[1]]
        moves = scale > 0.0
        if not moves.any():
            return np.zeros(len(change))
        far: Float = np.mean(change[:, moves] / scale[moves], axis=1)
        return far
