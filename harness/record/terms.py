"""What is agreed on before the first training: which questions are asked, and when."""

from dataclasses import dataclass

from harness.files.plain import Plain


@dataclass(frozen=True)
class Terms(Plain):
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


FIRST = Terms()
"""The terms of experiments that version 0.1 began, and of recordings that no experiment made."""
NEW = Terms(averaged=5)
"""The terms of experiments that are begun now and train all seeds at once."""
