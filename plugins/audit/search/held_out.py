"""Where chance decides: policies, and what they come to from starts that no search has played."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness import Float, Ints
from harness.eta import mean_over_seeds
from harness.eta.interval import CONFIDENCE

from .behaviour import AS_FAST, Behaviour, Rated, Rates, Role, Searched, Three
from .linear import LINEAR, act_linear, search_linear
from .sampled_table import sample_tables
from .table import TABLE, TRAINING, act_by_table, decides_by_chance
from .world import Act, Data, Rng, World

HELD_OUT = 1_000_000, 2_000_000
"""Seeds of resets that policies are rated on."""
SHARES = (0.5, 0.2, 0.3)
"""Parts of a budget: to find policies, to choose among them, and to rate them."""
FEWEST, MOST = 24, 200
"""Episodes of a policy that is rated."""
CLEARLY = 0.05
"""Rates of success that differ by no more than this are about the same."""


def act_of(policy: Data, world: World) -> Act:
    """What a policy does that is given as plain data: one of a table, a linear one, or random actions.

    Args:
        policy: See `Behaviour.policy`.
        world: Where it acts.
    """
    if policy["kind"] == TABLE:
        return act_by_table(policy)
    if policy["kind"] == LINEAR:
        return act_linear(policy, world)
    space = world.space
    space.seed(policy["seed"])
    return lambda observed: space.sample()


def share_interval(flags: NDArray[np.bool_]) -> tuple[float, float, float]:
    """A share and its 95 % interval by Wilson (1927): share, low, high."""
    from scipy.stats import binomtest  # here, since importing it takes time that few searches need

    found = binomtest(int(flags.sum()), len(flags))
    return (float(found.statistic), *found.proportion_ci(CONFIDENCE, "wilson"))


def search_by_chance(world: World, starts: Ints, budget: int, rng: Rng) -> Searched | None:
    """What a search for policies found where chance decides; None where it does not.

    The means of policies over held-out starts take the place of three behaviours for each start, see `three_of`.

    Args:
        world: Where.
        starts: Linear policies are looked for from these.
        budget: About so many steps are taken.
        rng: Draws seeds and actions.
    """
    begun = world.taken
    find, choose, rate = (int(share * budget) for share in SHARES)
    if not decides_by_chance(world, find // 5, rng):
        return None
    find -= world.taken - begun
    policies = sample_tables(world, find, rng)
    if not policies:
        policies = search_linear(world, starts, lambda *_: None, find, rng)
    policies.append({"kind": "random", "seed": int(rng.integers(2**31))})
    training = rng.integers(*TRAINING, _episodes(choose, len(policies), world))
    tried = [_rated(world, policy, training) for policy in policies]
    most = max(it.outcomes.success.mean() for it in tried)
    good = [it for it in tried if it.outcomes.success.mean() >= max(most - CLEARLY, most / 2)] if most else []
    times = [it.outcomes.time[it.outcomes.success].mean() for it in good]
    fast = [it for it, time in zip(good, times, strict=True) if time <= AS_FAST * min(times)]

    def best(of: list[Rated], pays: str = "paid") -> Rated:
        return max(of, key=lambda it: float(getattr(it.outcomes, pays).mean()))

    succeeding = {"success": best(good), "fastest": best(fast)} if good else {}
    roles = {"paid": best(tried), "discounted": best(tried, "discounted"), **succeeding, "random": tried[-1]}
    held_out = rng.integers(*HELD_OUT, _episodes(rate, 5, world))
    again = {id(it): _rated(world, it.policy, held_out) for it in roles.values()}
    rates = {role: again[id(it)] for role, it in roles.items()}
    return Searched(
        plain=[three_of(rates, discounted=False)],
        discounted=[three_of(rates, discounted=True)],
        typical=[float(np.median(rates["random"].outcomes.paid))],
        typical_discounted=[float(np.median(rates["random"].outcomes.discounted))],
        successes=[int(rates["success"].outcomes.success.sum()) if "success" in rates else 0],
        climbing=[0.0],
        steps=world.taken - begun,
        how=("sampled table" if rates["paid"].policy["kind"] == TABLE else "linear policies",),
        rates=rates,
    )


def _episodes(budget: int, policies: int, world: World) -> int:
    return int(np.clip(budget // (policies * world.horizon), FEWEST, MOST))


def _rated(world: World, policy: Data, starts: Ints) -> Rated:
    outcomes, actions = world.act(starts, act_of(policy, world))
    return Rated(policy, starts.tolist(), outcomes, actions[0])


def three_of(rates: Rates, *, discounted: bool) -> Three:
    """The three behaviours of a world where chance decides: means of policies over held-out starts.

    The policy that is paid most is the failure if it clearly succeeds more seldom than the one that succeeds most, by a
    paired 95 % interval, and the best-paid success if it does not. One that is not clearly paid more than that one is
    left out.
    """
    most = rates["discounted" if discounted else "paid"]
    if "success" not in rates:
        return {"failure": _mean_behaviour(most, success=False)}
    surest, found = rates["success"], dict[Role, Behaviour]()
    success, fastest = (_mean_behaviour(it, success=True) for it in (surest, rates["fastest"]))
    pays = [it.outcomes.discounted if discounted else it.outcomes.paid for it in (most, surest)]
    if _is_above_zero(pays[0] - pays[1]):
        rarer = surest.outcomes.success.astype(float) - most.outcomes.success
        if rarer.mean() > CLEARLY and _is_above_zero(rarer):
            found["failure"] = _mean_behaviour(most, success=False)
        else:
            success = _mean_behaviour(most, success=True)
    return {**found, "success": success, "fastest": fastest}


def _is_above_zero(values: Float) -> bool:
    """Whether the 95 % interval of a mean is."""
    return (mean_over_seeds(values.tolist()).low or 0.0) > 0.0


def _mean_behaviour(rated: Rated, *, success: bool) -> Behaviour:
    """The mean of a policy over its starts, with the actions of the first."""
    of = rated.outcomes
    succeeded: Any = of.success if success and of.success.any() else slice(None)
    numbers = (of.paid, of.discounted, of.steps, of.time[succeeded], of.share)
    paid, discounted, steps, time, share = (float(np.mean(values)) for values in numbers)
    measures = {name: float(np.nanmean(values)) for name, values in of.measures.items()}
    return Behaviour(
        rated.starts[0], rated.actions, paid, discounted, success, round(steps), round(time), share, measures,
        rated.policy["kind"], rated.policy,
    )  # fmt: skip
