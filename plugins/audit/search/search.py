"""One search: what a reward pays most, for failing and for succeeding, from given starts and within a budget of steps.

Three families share the budget. Where a world is a table, that is exact, and nothing else is asked, unless a few
sequences are paid more than it says: what nobody observes, such as what a reward remembers, is no state of it. Linear
policies find what needs balance. Sequences of actions find the rest, and begin from whatever the others have met.
"""

from collections.abc import Sequence
from copy import deepcopy
from dataclasses import replace

import numpy as np

from .behaviour import Searched
from .held_out import search_by_chance
from .kept import Kept
from .linear import search_linear
from .sequences import Evolution, evolve
from .table import TABLE, search_tables
from .world import Beginning, World

SEQUENCES, POLICIES = "sequences", "linear policies"
"""The families, as `Searched.how` names them."""
ROUNDS, FEWEST, AT_RANDOM = 32, 6, 0.05
"""Random episodes of each start: so many, or this share of the budget if it is smaller, but not fewer than a few."""
IN_TABLES, IN_POLICIES = 0.3, 0.25
"""The share of a budget that may go into learning a table, and into linear policies."""
IN_DOUBT = 0.02
"""The share that goes into sequences that are paid more than a table says."""


def search(
    world: World, starts: Sequence[int], budget: int, seed: int, beginnings: Sequence[Beginning] = ()
) -> Searched:
    """Look for what is paid most.

    Args:
        world: Where, and by which reward.
        starts: The seeds of the resets that are searched.
        budget: About so many steps are taken.
        seed: Of the search; the same one finds the same.
        beginnings: Behaviours that it begins from.
    """
    begun, rng = world.taken, np.random.default_rng(seed)
    kept = Kept(starts, world.horizon)
    evolution = Evolution(world, kept, rng)
    episodes = budget // (world.horizon * len(starts))
    typical, later = evolution.random(int(np.clip(AT_RANDOM * episodes, FEWEST, ROUNDS)))
    for beginning in beginnings:
        if beginning.act is not None:
            outcomes, taken = world.act(kept.starts, beginning.act)
        else:
            filled = [evolution.filled(it) for it in beginning.actions]
            taken = filled * (len(starts) // len(filled))
            outcomes = world.play(kept.starts, np.stack(taken))
        evolution.take(np.arange(len(starts)), taken, outcomes, beginning.made_by)
    climbing = [0.0] * len(starts)
    how: tuple[str, ...] = (TABLE,)
    is_table = search_tables(world, list(starts), evolution.take, int(IN_TABLES * budget), rng)
    if is_table:
        counted = deepcopy(kept)
        evolve(evolution, int(IN_DOUBT * budget))
        is_table = not kept.is_paid_more_than(counted)
        kept = counted if is_table else kept
    if not is_table:
        by_chance = search_by_chance(world, kept.starts, budget - (world.taken - begun), rng)
        if by_chance is not None:
            return replace(by_chance, steps=world.taken - begun)
        how = (SEQUENCES,)
        if world.together == 1 and search_linear(world, kept.starts, evolution.take, int(IN_POLICIES * budget), rng):
            how = (SEQUENCES, POLICIES)
        climbing = evolve(evolution, budget - (world.taken - begun))
    plain, after = (
        [of.three(usual, not is_table) for of, usual in zip(bests, usually, strict=True)]
        for bests, usually in ((kept.plain, typical), (kept.discounted, later))
    )
    return Searched(
        plain=plain,
        discounted=after,
        typical=typical,
        typical_discounted=later,
        successes=kept.successes,
        climbing=climbing,
        steps=world.taken - begun,
        how=how,
    )
