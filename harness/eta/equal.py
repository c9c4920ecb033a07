"""Trainings that are equal bit for bit: two rewards that taught the same steps, or two seeds that gave one run."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeAlias

Key: TypeAlias = tuple[str, int]
"""The reward and the seed of a training."""


def equal_trainings(digests: Mapping[Key, str]) -> tuple[tuple[Key, ...], ...]:
    """Trainings that are equal bit for bit, together.

    Args:
        digests: Of all that each training recorded; empty where equal ones would say nothing.
    """
    found: dict[str, list[Key]] = {}
    for key, digest in digests.items():
        if digest:
            found.setdefault(digest, []).append(key)
    return tuple(tuple(keys) for keys in found.values() if len(keys) > 1)


def key_to_json(key: Key) -> dict[str, str | int]:
    """Plain data."""
    reward, seed = key
    return {"trained_by": reward, "seed": seed}


def equal_sentences(groups: Iterable[Sequence[Key]]) -> list[str]:
    """The same in words: a line for all seeds of the same rewards, and one for each other group."""
    seeds: dict[tuple[str, ...], list[int]] = {}
    lines = []
    for group in groups:
        if len({seed for _, seed in group}) == 1:
            seeds.setdefault(tuple(reward for reward, _ in group), []).append(group[0][1])
        else:
            told = _listed(f"by {reward} with seed {seed}" for reward, seed in group)
            lines.append(f"The trainings {told} are equal bit for bit. They count as several, but are one")
    of_seeds = [
        f"The trainings by {_listed(rewards)} are equal bit for bit, with {'seeds' if len(of) > 1 else 'seed'} "
        f"{_listed(map(str, of))}: between them there is nothing to compare"
        for rewards, of in seeds.items()
    ]
    return [*of_seeds, *lines]


def _listed(names: Iterable[str]) -> str:
    *most, last = names
    return f"{', '.join(most)} and {last}" if most else last
