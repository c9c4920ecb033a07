"""What the metadata of a data set declares, held against what lies there.

The metadata decide what belongs. Episodes that lie there beside it are left out and told. An episode, or a step, that
is declared and does not lie there is a gap: the data set is refused, unless the user takes a part of it.
"""

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from pathlib import Path

from harness.errors import SchemaError

SHOWN = 5
"""So many numbers of episodes are told."""


@dataclass(frozen=True)
class Declared:
    """What the metadata says.

    Attributes:
        episodes: How many there are; None if it does not say so.
        steps: How many steps; None likewise.
        listed: Numbers of the episodes that it lists; empty if it lists none.
        lengths: How many steps it says that an episode has, by number.
    """

    episodes: int | None = None
    steps: int | None = None
    listed: Collection[int] = ()
    lengths: Mapping[int, int] = field(default_factory=dict)


@dataclass(frozen=True)
class Census:
    """What belongs to a data set.

    Attributes:
        episodes: Numbers of the episodes that are read.
        notes: How what lies there differs from what is declared, a line each.
    """

    episodes: frozenset[int]
    notes: tuple[str, ...] = ()


def take_census(path: Path, declared: Declared, found: Mapping[int, int], partial: bool) -> Census:
    """Which episodes belong to the data set.

    Args:
        path: The data set, for messages.
        declared: What the metadata says.
        found: Steps of each episode that lies there, by number.
        partial: Whether a part of what is declared is enough.

    Raises:
        SchemaError: Something that is declared does not lie there, or not as it is declared.
    """
    belonging = _belonging(declared, found)
    notes = []
    beside = sorted({*found} - belonging)
    if beside:
        notes.append(f"Left out, since the metadata does not list them: {_episodes(beside)}")
    empty = sorted(
        {number for number in {*declared.listed, *belonging} if not found.get(number, _length(declared, number))}
    )
    if empty:
        notes.append(f"Left out, since they have no step: {_episodes(empty)}")
    gaps = list(_gaps(declared, found, belonging))
    other = [number for number in sorted(belonging) if declared.lengths.get(number, found[number]) != found[number]]
    if other:
        steps = f"episode {other[0]} has {found[other[0]]:,} steps, {declared.lengths[other[0]]:,} are declared"
        gaps.append(f"{_episodes(other)} of another length than declared ({steps})")
        belonging -= {*other}
    if gaps and not partial:
        raise SchemaError(
            f"{path} is not what its metadata declares: {'; '.join(gaps)}. Fetch it again, or take what is there with "
            "--partial"
        )
    notes += [f"In spite of --partial, not as declared: {gap}" for gap in gaps]
    return Census(frozenset(belonging), tuple(notes))


def _belonging(declared: Declared, found: Mapping[int, int]) -> set[int]:
    if declared.listed:
        return {*declared.listed} & {*found}
    if declared.episodes is not None and len(found) > declared.episodes:
        below = {number for number in found if number < declared.episodes}
        return below if len(below) == declared.episodes else {*found}
    return {*found}


def _gaps(declared: Declared, found: Mapping[int, int], belonging: Collection[int]) -> list[str]:
    gaps = []
    gone = sorted(number for number in {*declared.listed} - {*found} if _length(declared, number))
    if gone:
        gaps.append(f"{_episodes(gone)} declared and not there")
    if declared.episodes is not None:
        count = len(declared.listed) or len(belonging)
        if count != declared.episodes:
            noun = "listed" if declared.listed else "there"
            gaps.append(f"{declared.episodes:,} episodes declared, {count:,} {noun}")
    steps = sum(found[number] for number in belonging)
    if declared.steps is not None and steps != declared.steps:
        gaps.append(f"{declared.steps:,} steps declared, {steps:,} there")
    return gaps


def _length(declared: Declared, number: int) -> int:
    """How many steps an episode should have; where nothing says it, some."""
    return declared.lengths.get(number, 1)


def _episodes(numbers: list[int]) -> str:
    shown = ", ".join(map(str, numbers[:SHOWN])) + (" ..." if len(numbers) > SHOWN else "")
    return f"{len(numbers):,} {'episode' if len(numbers) == 1 else 'episodes'} ({shown})"
