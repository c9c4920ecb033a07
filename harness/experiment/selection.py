"""Selects cells of a plan by name: ``--only``."""

from collections.abc import Iterable, Mapping, Sequence

from harness.errors import UsageError
from harness.record.cell import Cell
from harness.registry.choice import split_list

KINDS = ("simulator", "algorithm", "reward", "seed", "cell")


def select(cells: Sequence[Cell], text: str) -> tuple[Cell, ...]:
    """The cells that `text` names.

    Each word is the name or label of a simulator, algorithm or reward, ``seed=3``, or the id of a cell. Words of one
    kind are alternatives; words of several kinds all have to hold: ``sac,ppo,seed=0`` is seed 0 of both algorithms.

    Raises:
        UsageError: A word names nothing in these cells.
    """
    asked: dict[str, set[str]] = {}
    for word in split_list(text):
        kinds = [kind for kind in KINDS if any(word in _names(cell)[kind] for cell in cells)]
        if not kinds:
            raise UsageError(f"--only: no cell of this experiment has '{word}'. Allowed are {_offer(cells)}")
        asked.setdefault(kinds[0], set()).add(word)
    return tuple(cell for cell in cells if all(words & set(_names(cell)[kind]) for kind, words in asked.items()))


def _names(cell: Cell) -> Mapping[str, Sequence[str]]:
    """The words that name a cell, by kind."""
    choices = {"simulator": cell.place, "algorithm": cell.algorithm, "reward": cell.reward}
    named = {kind: (choice.label, choice.name) for kind, choice in choices.items()}
    return {**named, "seed": (f"seed={cell.seed}",), "cell": (cell.id,)}


def _offer(cells: Iterable[Cell]) -> str:
    """The words that are possible, without the ids of cells."""
    found: dict[str, dict[str, None]] = {kind: {} for kind in KINDS[:-1]}
    for cell in cells:
        for kind, names in found.items():
            names[_names(cell)[kind][0]] = None
    return ", ".join(name for names in found.values() for name in names)
