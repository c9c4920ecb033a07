"""Experiments that are trained in looks, until there is an answer."""

import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import numpy as np

from harness.errors import UsageError
from harness.eta.verdict.looks import check_looks, looks_for
from harness.eta.verdict.race import RACE
from harness.experiment.task_plan import TaskPlan
from harness.record.cell import Cell
from harness.record.plan_file import StoredPlan
from harness.record.terms import NEW, Terms
from harness.registry.choice import Choice


class Asked(Protocol):
    """What an experiment says about its looks; see `harness.experiment.plan.Experiment`."""

    @property
    def until(self) -> str:
        """``decided`` or ``best``."""

    @property
    def looks(self) -> list[int] | None:
        """Seeds at each look; None for the usual ones."""

    @property
    def margin(self) -> float:
        """A difference below this ends the training."""


def terms_of(asked: Asked, tasks: Sequence[TaskPlan], algorithms: Sequence[Choice]) -> Terms:
    """What an experiment agrees on before its first training.

    Raises:
        UsageError: The looks cannot be used, or the baseline is compared with itself.
    """
    if any(it.has_control for it in tasks):
        raise UsageError(
            f"until={asked.until}: the null control compares the baseline with itself, and has no answer to wait for. "
            "Leave the baseline out of the rewards"
        )
    rewards = len(dict.fromkeys(reward for it in tasks for reward in it.rewards))
    if not rewards:
        raise UsageError(f"until={asked.until}: there is no reward to compare with the baseline. Give --reward")
    places = sum(len(it.simulators) for it in tasks) * len(algorithms)
    is_race = asked.until == "best"
    looks = (RACE if is_race else looks_for(places)) if asked.looks is None else tuple(asked.looks)
    problem = check_looks(looks)
    if problem:
        raise UsageError(f"looks={','.join(map(str, looks))}: {problem}")
    return Terms(looks, rewards + is_race, asked.margin, is_race, averaged=NEW.averaged)


def refuse_other_looks(folder: Path, earlier: StoredPlan, terms: Terms, asked: Sequence[Cell]) -> None:
    """See that an experiment with looks goes on as it was begun.

    Args:
        folder: The experiment's.
        earlier: What was asked for in it before.
        terms: What is agreed on now.
        asked: The cells that are asked for now.

    Raises:
        UsageError: Looks, margin, rewards or places are others than at the first look, or a folder without looks gets
            some. Nothing is written.
    """
    if not earlier.terms.looks and not terms.looks:
        return
    if earlier.terms == terms and set(asked) == set(earlier.cells):
        return
    what = "its looks, its margin, its rewards or its places are others" if terms.looks else "it is trained in looks"
    if not earlier.terms.looks:
        what = "it was begun without looks, so its seeds were not foreseen"
    raise UsageError(
        f"'{folder}': {what}. What an experiment with looks asks is settled before its first training: "
        "name a new folder, --out NEW"
    )


def own_seed(cell: Cell) -> Cell:
    """The cell with a seed that no other place has: equal seeds in several places would say less together."""
    place = f"{cell.simulator.label} {cell.robot} {cell.task.label} {cell.algorithm.label}"
    words = np.random.SeedSequence([cell.seed, zlib.crc32(place.encode())]).generate_state(1)
    return replace(cell, seed=int(words[0] & 0x7FFFFFFF))
