"""What is agreed on before the first training: which questions are asked, and when."""

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

from pydantic import AfterValidator, ConfigDict, Field, with_config

from harness.files.plain import Plain
from harness.record.file_forms import MOST_CELLS, MOST_LOOKS, MOST_SEEDS, Count, Name, Whole


def _increasing(looks: tuple[int, ...]) -> tuple[int, ...]:
    if any(b <= a for a, b in pairwise(looks)):
        raise ValueError("does not increase")
    return looks


Look = Annotated[int, Field(gt=0, le=MOST_SEEDS)]


@with_config(ConfigDict(strict=True))
@dataclass(frozen=True)
class Terms(Plain):
    """How an experiment's answers are found. They stand in ``plan.json`` before anything is trained.

    Attributes:
        looks: The seeds of each reward in each place at each look, increasing; empty where all are trained at once.
        asked: In an experiment with looks: how many rewards are compared with the baseline.
        margin: In an experiment with looks: a difference below this ends the training.
        race: Whether `harness choose` of version 0.3 or earlier made the looks, and dropped rewards at them.
        averaged: The final policy counts with the mean over so many evaluations, the last ones, where there are any on
            the way.
        grown: By how many seeds were done when more of them were asked for, though no plan foresaw it.
        joined: The labels of rewards that were asked for when results of others could be seen.
        budget: The most trainings that `harness choose` may spend; 0 in other experiments. Its candidates are `asked`.
        seconds: The time that it may spend, which its first trainings turn into a number of them; 0 if none was given.
    """

    looks: Annotated[tuple[Look, ...], Field(max_length=MOST_LOOKS), AfterValidator(_increasing)] = ()
    asked: Count = 1
    margin: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] = 0.0
    race: bool = False
    averaged: Count = 1
    grown: Annotated[tuple[Whole, ...], Field(max_length=MOST_LOOKS)] = ()
    joined: Annotated[tuple[Name, ...], Field(max_length=MOST_CELLS)] = ()
    budget: Annotated[int, Field(ge=0, le=MOST_CELLS)] = 0
    seconds: Annotated[float, Field(ge=0.0, allow_inf_nan=False)] = 0.0

    @property
    def has_plan(self) -> bool:
        """Whether all seeds that an answer may need were planned before the first training."""
        return bool(self.looks or self.budget)


FIRST = Terms()
"""The terms of experiments that version 0.1 began, and of recordings that no experiment made."""
NEW = Terms(averaged=5)
"""The terms of experiments that are begun now and train all seeds at once."""
