"""What data sets of every format have in common: their facts, the bounds on what is read, and usual names."""

from collections.abc import Collection, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from harness.errors import SchemaError
from harness.log import require_columns

SHOWN = 5
"""So many numbers of episodes are told."""


def take_census(
    path: Path,
    found: Mapping[int, int],
    *,
    partial: bool,
    episodes: int | None = None,
    steps: int | None = None,
    listed: Collection[int] = (),
    lengths: Mapping[int, int] = {},
) -> tuple[frozenset[int], list[str]]:
    """Which episodes belong to the data set, and how what lies there differs from what is declared, a line each.

    Args:
        path: The data set, for messages.
        found: Steps of each episode that lies there, by number.
        partial: Whether a part of what is declared is enough.
        episodes: How many the metadata declares; None if it does not say so.
        steps: How many steps; None likewise.
        listed: Numbers of the episodes that it lists; empty if it lists none.
        lengths: How many steps it says that an episode has, by number.

    Raises:
        SchemaError: Something that is declared does not lie there, or not as it is declared.
    """
    there, named = {*found}, {*listed}
    below = {number for number in there if number < (episodes or 0)}
    belonging = there & named if named else below if len(below) == episodes else there
    beside = there - belonging
    empty = {number for number in named | belonging if not found.get(number, lengths.get(number, 1))}
    gone = {number for number in named - there if lengths.get(number, 1)}
    other = sorted(number for number in belonging if lengths.get(number, found[number]) != found[number])
    count, total = len(named or belonging), sum(found[number] for number in belonging)
    notes, gaps = [], []
    if beside:
        notes.append(f"Left out, since the metadata does not list them: {_episodes(beside)}")
    if empty:
        notes.append(f"Left out, since they have no step: {_episodes(empty)}")
    if gone:
        gaps.append(f"{_episodes(gone)} declared and not there")
    if episodes not in (None, count):
        gaps.append(f"{episodes:,} episodes declared, {count:,} {'listed' if named else 'there'}")
    if steps not in (None, total):
        gaps.append(f"{steps:,} steps declared, {total:,} there")
    if other:
        told = f"episode {other[0]} has {found[other[0]]:,} steps, {lengths[other[0]]:,} are declared"
        gaps.append(f"{_episodes(other)} of another length than declared ({told})")
    if gaps and not partial:
        raise SchemaError(
            f"{path} is not what its metadata declares: {'; '.join(gaps)}. Fetch it again, or take what is there with "
            "--partial"
        )
    notes += [f"In spite of --partial, not as declared: {gap}" for gap in gaps]
    return frozenset(belonging.difference(other)), notes


def _episodes(numbers: Collection[int]) -> str:
    shown = ", ".join(map(str, sorted(numbers)[:SHOWN])) + (" ..." if len(numbers) > SHOWN else "")
    return f"{len(numbers):,} {'episode' if len(numbers) == 1 else 'episodes'} ({shown})"


ROWS = 16_384
"""The most steps that are read at a time."""
PIECE_BYTES = 2**25
"""The most bytes of the numbers of these, 32 MiB; wide observations come in fewer steps."""
MOST_STEPS = 100_000_000
MOST_NUMBERS = 16_384
"""The most numbers of one observation, or of one action: pictures are left out."""
MOST_KEYS = 1_000
"""The most columns, or parts of an observation; of an episode's parts all together."""
MOST_VALUES = 20_000_000_000
"""The most numbers that are read of a data set: steps times the numbers of each."""
SUCCESS_KEYS = ("success", "is_success")
"""What a column may be called that says whether a step was a success."""
OPERATOR_KEYS = ("operator", "operator_id")
"""What may be called who, or what, made an episode."""
NOTHING_SEEN = "recorded pay is read, and functions that look at no observation"
"""What is left of a data set whose observations hold no numbers."""


def require_readable(path: Path, steps: int, width: int) -> None:
    """Bounds on what is read, before any of it is.

    Raises:
        SchemaError: So many steps of so many numbers are too much.
    """
    if steps > MOST_STEPS:
        raise SchemaError(f"{path} has more than {MOST_STEPS:,} steps, which is not allowed")
    if steps * width > MOST_VALUES:
        raise SchemaError(f"{path} has {steps * width:,} numbers, {MOST_VALUES:,} are allowed")


def whole(value: Any) -> int | None:
    """A number of episodes or steps, at least 0, as JSON or HDF5 has it; None where it is anything else."""
    return int(value) if isinstance(value, int | np.integer) and not isinstance(value, bool) and value >= 0 else None


def rows_at_once(bytes_of_row: int) -> int:
    """How many steps are read at a time, if each has so many bytes."""
    return max(1, min(ROWS, PIECE_BYTES // max(1, bytes_of_row)))


def chosen_key(flag: str, named: str, told: Collection[str], usual: Iterable[str], path: Path) -> str:
    """The key that the user names, or the first of the usual ones that is there; empty if none is.

    Args:
        flag: By which the user names it.
        named: By the user, or empty.
        told: The keys that are there.
        usual: Keys that mostly say it.
        path: Of the data set, for messages.

    Raises:
        UsageError: The key that the user names is not there; says which are.
    """
    require_columns(f"{flag} {named}: {path}", dict.fromkeys(told), named)
    return named or next((key for key in usual if key in told), "")
