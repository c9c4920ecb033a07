"""Experiments that are trained in looks, until there is an answer."""

import zlib
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Protocol

import numpy as np

from harness.errors import UsageError
from harness.eta.verdict.halving import MOST, fewest, usual
from harness.eta.verdict.looks import check_looks, looks_for
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

    @property
    def trainings(self) -> int | None:
        """What `harness choose` may spend; None for the usual number, or for `minutes`."""

    @property
    def minutes(self) -> float | None:
        """What it may spend, in minutes."""


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
    if asked.until == "best":
        return _terms_of_choosing(asked, rewards, places)
    looks = looks_for(places) if asked.looks is None else tuple(asked.looks)
    problem = check_looks(looks)
    if problem:
        raise UsageError(f"looks={','.join(map(str, looks))}: {problem}")
    return Terms(looks, rewards, asked.margin, averaged=NEW.averaged)


def _terms_of_choosing(asked: Asked, candidates: int, places: int) -> Terms:
    """See `terms_of`. Of a budget in minutes all cells are planned that the longest one may need."""
    if asked.looks is not None:
        raise UsageError("looks go with until=decided: harness choose has a budget instead, --budget 60")
    if candidates < 2:
        raise UsageError("one candidate leaves nothing to choose: name more rewards, or compare it: harness run")
    least, most = fewest(candidates, places), usual(candidates, places)
    if asked.minutes is not None:
        return Terms(asked=candidates, averaged=NEW.averaged, budget=MOST * most, seconds=60.0 * asked.minutes)
    budget = most if asked.trainings is None else asked.trainings
    if budget < least:
        raise UsageError(
            f"--budget {budget}: {least} trainings are the fewest that can tell anything of {candidates} candidates"
            f"{f' in {places} places' if places > 1 else ''}; {most} are usual. Give --budget {least} or more"
        )
    return Terms(asked=candidates, averaged=NEW.averaged, budget=budget)


def refuse_other_looks(
    folder: Path, earlier: StoredPlan, terms: Terms, asked: Sequence[Cell], *, is_open: bool = False
) -> None:
    """See that an experiment that was planned to its end goes on as it was begun.

    Args:
        folder: The experiment's.
        earlier: What was asked for in it before.
        terms: What is agreed on now.
        asked: The cells that are asked for now.
        is_open: Whether nobody was asked about yet, so that the time may still be another one.

    Raises:
        UsageError: Looks, margin, budget, rewards or places are others than at first, or a folder without looks gets
            some, or it is a race of an earlier version. Nothing is written.
    """
    if earlier.terms.race:
        raise UsageError(
            f"'{folder}' holds a race that version 0.3 or an earlier one began; rewards are chosen in another way now: "
            "name a new folder, --out NEW"
        )
    if not earlier.terms.has_plan and not terms.has_plan:
        return
    agreed = replace(earlier.terms, seconds=terms.seconds) if is_open and earlier.terms.seconds else earlier.terms
    if agreed == terms and set(asked) == set(earlier.cells):
        return
    what = "its looks, its margin, its budget, its rewards or its places are others"
    if not terms.has_plan:
        what = "it is trained in looks" if earlier.terms.looks else "it chooses one of several rewards"
    if not earlier.terms.has_plan:
        what = "it was begun without looks, so its seeds were not foreseen"
    raise UsageError(
        f"'{folder}': {what}. What it asks is settled before its first training: name a new folder, --out NEW"
    )


def own_seed(cell: Cell) -> Cell:
    """The cell with a seed that no other place has: equal seeds in several places would say less together."""
    place = f"{cell.simulator.label} {cell.robot} {cell.task.label} {cell.algorithm.label}"
    words = np.random.SeedSequence([cell.seed, zlib.crc32(place.encode())]).generate_state(1)
    return replace(cell, seed=int(words[0] & 0x7FFFFFFF))
