"""What is agreed on before the first training: which questions are asked, and when."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any, Self


@dataclass(frozen=True)
class Terms:
    """How an experiment's answers are found. They stand in ``plan.json`` before anything is trained.

    Attributes:
        looks: The seeds of each reward in each place at each look, increasing; empty where all are trained at once.
        asked: In an experiment with looks: how many rewards are compared with the baseline.
        margin: In an experiment with looks: a difference below this ends the training.
        race: Whether the looks are those of `harness choose`, which asks for the best of several rewards.
        averaged: The final policy counts with the mean over so many evaluations, the last ones, where there are any on
            the way.
        grown: By how many seeds were done when more of them were asked for, though no plan foresaw it.
        joined: The labels of rewards that were asked for when results of others could be seen.
    """

    looks: tuple[int, ...] = ()
    asked: int = 1
    margin: float = 0.0
    race: bool = False
    averaged: int = 1
    grown: tuple[int, ...] = ()
    joined: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {name: list(told) if isinstance(told, tuple) else told for name, told in asdict(self).items()}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """The inverse of `to_json`; what is missing has its default."""
        known = {field.name for field in fields(cls)}
        told: dict[str, Any] = {
            name: tuple(value) if isinstance(value, list) else value for name, value in data.items() if name in known
        }
        return cls(**told)


FIRST = Terms()
"""The terms of experiments that version 0.1 began, and of recordings that no experiment made."""
NEW = Terms(averaged=5)
"""The terms of experiments that are begun now and train all seeds at once."""
