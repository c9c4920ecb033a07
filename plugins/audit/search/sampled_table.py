"""Tables of worlds where chance decides: counted over many episodes, and solved for policies by value iteration."""

from collections import Counter, defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from gymnasium.spaces import Discrete

from harness import Float, Ints, Mask
from harness.log.log import episode_sum

from .table import ENOUGH, MOST_ACTIONS, MOST_NEW, TRAINING, Pair, table_policy, transitions
from .world import Act, Data, Rng, World, key_of

MOST_STATES = 20_000
KNOWN, FEWEST = 16, 3
"""So often an action is tried in every state if there is time; a policy takes none that was tried more seldom."""
LOOKS = 8
"""Episodes between two plans of what to try next."""
CURIOUS = 0.97
"""The discount per step of a plan that goes to what was tried too seldom."""
EXACT, SWEEPS = 1e-6, 5_000
"""Value iteration ends if no value changes by more than this, as a share of the largest; or after so many sweeps."""
BONUSES = (0.3, 1.0, 10.0, 1000.0)
"""What success is worth to the policies that are asked for, beside pay: so many times the range of pay per episode."""
HASTES = (0.9, 0.97)
"""Discounts per step of the policies that are to succeed soon."""
EXPLORED, ROUNDS, EACH = 0.6, 4, 25
"""The share of the steps that may go to what was tried too seldom; in the rest policies are solved anew so often, and
played in so many episodes each at most."""


@dataclass(frozen=True, eq=False)
class Sampled:
    """Means of what was counted.

    Attributes:
        tried: How often each action was tried, (states, actions).
        paid: What it paid on average, (states, actions).
        ended_well: How often it ended an episode in success, a share, (states, actions).
        success: How often it was a success that ended nothing, likewise.
        moves: How often it led to each state, a share, (states * actions, states).
    """

    tried: Float
    paid: Float
    ended_well: Float
    success: Float
    moves: Any

    def succeeds(self, discount: float) -> Float:
        """What each action is worth for success alone: 1 for an end in it, and for all steps in it together."""
        return self.ended_well + (1.0 - discount) * self.success

    def choices(self, paid: Float, discount: float, allowed: Mask) -> Ints:
        """The action of each state that is worth most, by value iteration.

        Args:
            paid: What each action is worth, (states, actions).
            discount: Per step, below 1.
            allowed: What may be done, (states, actions).
        """
        value, worth = np.zeros(len(paid)), paid
        for _ in range(SWEEPS):
            worth = np.where(allowed, paid + discount * (self.moves @ value).reshape(paid.shape), -np.inf)
            better = np.where(allowed.any(axis=1), worth.max(axis=1), 0.0)
            change, value = np.abs(better - value).max(), better
            if change <= EXACT * np.abs(value).max():
                break
        best: Ints = worth.argmax(axis=1)
        return best


@dataclass(eq=False)
class Counts:
    """What was counted so far, in the episodes of any starts."""

    world: World
    space: Discrete
    rng: Rng

    def __post_init__(self) -> None:
        self.states: dict[str, int] = {}
        # by state and action, how often it was tried, what it paid, and how often it ended well, or was a success else
        self.tried, self.ended_well, self.success = Counter[Pair](), Counter[Pair](), Counter[Pair]()
        self.paid: dict[Pair, float] = defaultdict(float)
        self.moves = Counter[tuple[int, int, int]]()  # to which state it led
        self.news, self._longest = 0, 0
        self._returns = list[float]()

    def play(self, act: Act) -> None:
        """Play an episode of a policy from any start, and count it."""
        shown = self.world.watch(int(self.rng.integers(*TRAINING)), act)
        self._longest = max(self._longest, len(shown.actions))
        states = [self.states.setdefault(key_of(it), len(self.states)) for it in shown.observed]
        for at, after, paid, success in transitions(shown, states, self.space, self._longest):
            self.tried[at] += 1
            self.news += self.tried[at] <= KNOWN
            self.paid[at] += paid
            (self.ended_well if after < 0 else self.success)[at] += success
            if after >= 0:
                self.moves[*at, after] += 1
        self._returns.append(episode_sum(shown.paid))

    @property
    def is_table(self) -> bool:
        """Whether states are few, and met again."""
        often = len(self.tried) <= ENOUGH or len(self.states) <= MOST_NEW * len(self.tried)
        return len(self.states) <= MOST_STATES and often

    def means(self) -> Sampled:
        """What was counted, as shares of how often it was tried."""
        from scipy.sparse import csr_array

        shape = len(self.states), int(self.space.n)

        def filled(counts: Mapping[Pair, float]) -> Float:
            found = np.zeros(shape)
            for at, count in counts.items():
                found[at] = count
            return found

        tried = filled(self.tried)
        paid, ended_well, success = (
            filled(it) / np.maximum(tried, 1.0) for it in (self.paid, self.ended_well, self.success)
        )
        rows = [state * shape[1] + action for state, action, _ in self.moves]
        shares = [count / tried[state, action] for (state, action, _), count in self.moves.items()]
        moves = csr_array((shares, (rows, [after for *_, after in self.moves])), shape=(shape[0] * shape[1], shape[0]))
        return Sampled(tried, paid, ended_well, success, moves)

    def acting(self, choices: Ints) -> Act:
        """A policy of choices, of the states that were met when it is made; elsewhere it acts at random."""
        known, first, count = len(choices), int(self.space.start), int(self.space.n)

        def act(observed: Any) -> int:
            state = self.states.get(key_of(observed), known)
            return first + int(choices[state] if state < known else self.rng.integers(count))

        return act

    def seeking(self, plan: Ints) -> Act:
        """A policy that tries what was tried too seldom wherever it is, and follows a plan to such places."""
        count, now = int(self.space.n), Counter[Pair]()

        def act(observed: Any) -> int:
            state = self.states.get(key_of(observed), -1)
            tried = [now[state, action] + self.tried[state, action] for action in range(count)]
            action = int(np.argmin(tried))
            if tried[action] >= KNOWN:
                planned = int(plan[state]) if 0 <= state < len(plan) else -1
                is_old = planned < 0 or now[state, planned] >= KNOWN
                action = int(self.rng.integers(count)) if is_old else planned
            now[state, action] += 1
            return int(self.space.start) + action

        return act

    def policies(self) -> list[Ints]:
        """Choices that are paid most, by several discounts, that succeed most, and that succeed soon; no two alike."""
        means, horizon = self.means(), self._longest
        allowed = means.tried >= np.minimum(FEWEST, means.tried.max(axis=1, keepdims=True))
        allowed &= means.tried > 0
        patient, soon = 1.0 - 0.1 / horizon, 1.0 - 1.0 / horizon
        spread = float(np.ptp(self._returns)) or 1.0
        wanted = [(means.paid, discount) for discount in (self.world.gamma, soon, patient) if discount < 1.0]
        wanted += [(means.paid + bonus * spread * means.succeeds(soon), soon) for bonus in BONUSES]
        wanted += [(means.succeeds(discount), discount) for discount in (patient, *HASTES)]
        found = [means.choices(paid, discount, allowed) for paid, discount in wanted]
        return list({it.tobytes(): it for it in found}.values())


def sample_tables(world: World, budget: int, rng: Rng) -> list[Data]:
    """Policies, as plain data, for a world where chance decides; none if it is no table.

    Args:
        world: Where.
        budget: About so many steps are taken.
        rng: Draws starts, and actions where nothing is known.
    """
    if not isinstance(world.space, Discrete) or world.space.n > MOST_ACTIONS:
        return []
    counts, begun = Counts(world, world.space, rng), world.taken
    counts.play(counts.seeking(np.zeros(0, np.int64)))
    news = -1  # goes to what was tried too seldom until there is none
    while world.taken < begun + int(EXPLORED * budget) and news < counts.news and counts.is_table:
        means, news = counts.means(), counts.news
        seldom = np.where(means.tried < KNOWN, 1.0, 0.0)
        plan = means.choices(seldom, CURIOUS, seldom >= 0.0)
        for _ in range(LOOKS):
            counts.play(counts.seeking(plan))
    for part in range(ROUNDS, 0, -1):
        found = [counts.acting(choices) for choices in counts.policies()] if counts.is_table else []
        share = (begun + budget - world.taken) // (part * world.horizon)
        for _ in range(min(EACH, share // max(1, len(found)))):
            for act in found:
                counts.play(act)
    if not counts.is_table:
        return []
    keys = list(counts.states)
    return [table_policy(keys, choices + int(world.space.start)) for choices in counts.policies()]
