"""Exact tables: where states and actions are few, each is tried, and dynamic programming tells what is paid most.

Only ``reset(seed)`` and ``step`` are used. A table is believed if whatever was met twice agreed.
"""

import math
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from gymnasium.spaces import Discrete
from numpy.typing import NDArray

from harness import Float, Ints, Mask

from .behaviour import AS_FAST
from .world import Act, Actions, Data, Outcomes, Rng, Shown, World, key_of

MOST_ACTIONS = 32
MOST_CELLS = 10_000_000
"""States times steps of the horizon: each takes 10 bytes while a table is solved."""
MOST_NEW = 0.8
"""A world whose steps lead to new states more often than this, after `ENOUGH` of them, is no table."""
ENOUGH = 2_000
MOST_CHOICES = 2_000
"""States up to which an episode is also kept as a policy."""
TABLE = "table"
"""The kind of such a policy, and what its episodes are said to be made by."""
TRUE = 1e-6
"""An episode is paid what a table says if both differ by no more than this."""
CLOSE = 1e-9
"""Pay is the same if it differs by no more than this, of itself or of 1."""
TRAINING = 100_000, 1_000_000
"""Seeds of resets that are searched; trainings count theirs from 0, and evaluations have larger ones."""
RESETS = 32
"""So many starts are looked at to find two that begin alike."""


Pair: TypeAlias = tuple[int, int]
"""A state and an action."""
Keep: TypeAlias = Callable[[Ints, Sequence[Actions], Outcomes, str, Sequence[Data | None]], object]
"""Takes in episodes: their starts as places in the starts of a search, actions, outcomes, what made them, policies."""


class NoTableError(Exception):
    """States are too many to be learnt."""


class ContradictionError(NoTableError):
    """What was met twice did not agree."""


@dataclass(frozen=True, eq=False)
class Table:
    """What every action does in every state that can be reached.

    Attributes:
        keys: Of each state, the key of what is observed; none if a state is also when.
        begins: By start, the state that it begins in.
        next: The state after each action, (states, actions); -1 where the episode ends, or nobody tried.
        paid: What each pays, (states, actions); minus infinity where nobody tried, further away than the horizon.
        success: Whether a step is a success, (states, actions).
    """

    keys: Sequence[str]
    begins: Mapping[int, int]
    next: Ints
    paid: Float
    success: Mask


@dataclass(eq=False)
class Learner:
    """What is known of a table while it is learnt.

    Attributes:
        world: Where.
        space: Of its actions; they are counted from 0 here.
        rng: Draws actions where nothing is left to be tried.
        is_timed: Whether a state is what is observed and when, rather than what is observed.
    """

    world: World
    space: Discrete
    rng: Rng
    is_timed: bool

    def __post_init__(self) -> None:
        self.states: dict[str, int] = {}  # by what is observed, the number of a state
        # of each state, by action, the next state; -1 where the episode ends; filled while an episode goes on
        self.leads: list[dict[int, int]] = []
        # by state and action, what it paid and whether it was a success; filled after an episode
        self.known: dict[Pair, tuple[float, bool]] = {}
        self.begins: dict[int, int] = {}  # by start, the state that it begins in

    def state_of(self, observed: Any, step: int) -> int:
        """The number of a state; one that was never met gets the next number."""
        key = f"{step} {key_of(observed)}" if self.is_timed else key_of(observed)
        state = self.states.setdefault(key, len(self.leads))
        if state == len(self.leads):
            self.leads.append({})
        return state

    def plan(self, state: int, steps: int) -> list[int]:
        """Actions that lead to the nearest action that nobody tried, and it; empty if that takes more than `steps`."""
        came: dict[int, tuple[int, int]] = {state: (-1, -1)}
        queue = deque([(state, 0)])
        while queue:
            at, depth = queue.popleft()
            if depth >= steps:
                break
            if len(self.leads[at]) < self.space.n:
                way = [next(it for it in range(self.space.n) if it not in self.leads[at])]
                while at != state:
                    at, action = came[at]
                    way.insert(0, action)
                return way
            for action, after in self.leads[at].items():
                if after >= 0 and after not in came:
                    came[after] = (at, action)
                    queue.append((after, depth + 1))
        return []

    def explore(self) -> Act:
        """A policy for one episode: goes to what nobody tried as long as there is any, then acts at random."""
        taken, planned, last, is_done = 0, list[int](), (-1, -1), False

        def act(observed: Any) -> int:
            nonlocal taken, planned, last, is_done
            state = self.state_of(observed, taken)
            if taken:
                self.leads[last[0]].setdefault(last[1], state)
            if not planned and not is_done:
                planned = self.plan(state, self.world.horizon - taken)
                is_done = not planned
            taken += 1
            last = state, planned.pop(0) if planned else int(self.rng.integers(self.space.n))
            return int(self.space.start) + last[1]

        return act

    def play(self, start: int, act: Act) -> None:
        """Play an episode of a policy, and learn from it.

        Raises:
            ContradictionError: It is at odds with what was known.
            NoTableError: States are too many, or hardly any is met again.
        """
        shown, horizon = self.world.watch(start, act), self.world.horizon
        states = [self.state_of(observed, step) for step, observed in enumerate(shown.observed)]
        agrees = self.begins.setdefault(start, states[0]) == states[0]
        for at, after, paid, success in transitions(shown, states, self.space, horizon):
            before = self.known.setdefault(at, (paid, success))
            agrees &= self.leads[at[0]].setdefault(at[1], after) == after
            agrees &= success == before[1] and math.isclose(paid, before[0], rel_tol=CLOSE, abs_tol=CLOSE)
        if not agrees:
            raise ContradictionError
        tried = len(self.known)
        seldom_again = not self.is_timed and tried > ENOUGH and len(self.leads) > MOST_NEW * tried
        if seldom_again or len(self.leads) * horizon > MOST_CELLS:
            raise NoTableError

    def table(self, starts: Sequence[int], until: int) -> Table:
        """A table of some starts, after as many random steps again were asked whether they agree with it.

        Raises:
            ContradictionError: They do not.
            NoTableError: It is not learnt before the world has taken `until` steps.
        """
        world = self.world
        begun = world.taken
        for start in starts:
            self.play(start, self.explore())
            while self.plan(self.begins[start], world.horizon):
                if world.taken > until:
                    raise NoTableError
                self.play(start, self.explore())
        checked, first = min(2 * world.taken - begun, until), int(self.space.start)
        while world.taken < checked:
            for start in starts:
                self.play(start, lambda observed: first + int(self.rng.integers(self.space.n)))
        shape = len(self.leads), int(self.space.n)
        after, paid, success = np.full(shape, -1), np.full(shape, -np.inf), np.zeros(shape, bool)
        for (state, action), told in self.known.items():
            after[state, action] = self.leads[state][action]
            paid[state, action], success[state, action] = told
        return Table([] if self.is_timed else list(self.states), self.begins, after, paid, success)


def transitions(
    shown: Shown, states: Sequence[int], space: Discrete, horizon: int
) -> Iterator[tuple[Pair, int, float, bool]]:
    """Each step of an episode: the state and the action, the state after it, what it paid, whether it was a success.

    Instead of a state there is -1 where the step ended the episode by itself; the horizon is no end of a table.
    """
    for step, action in enumerate((shown.actions - space.start).tolist()):
        is_end = step == len(shown.actions) - 1 and (shown.ended == "terminated" or step + 1 < horizon)
        after = -1 if is_end else states[step + 1]
        yield (states[step], action), after, float(shown.paid[step]), bool(shown.success[step])


def learn_tables(world: World, starts: Sequence[int], budget: int, rng: Rng) -> dict[int, Table]:
    """By start, its table: one for all of them, or else one for each; empty if there is none in `budget` steps.

    What a seed draws and nobody observes, such as where a goal is, gives each start a table of its own. Where time
    matters that nobody observes (a limit on steps, pay that falls), a state is what is observed and when.
    """
    if not isinstance(world.space, Discrete) or world.space.n > MOST_ACTIONS or not world.is_repeated:
        return {}
    until = world.taken + budget
    for is_timed in (False, True):
        if is_timed and decides_by_chance(world, (until - world.taken) // 4, rng):
            return {}  # of a seed, even what chance brings is a matter of time
        for groups in ([starts], [[start] for start in starts]):
            try:
                learnt = [Learner(world, world.space, rng, is_timed).table(of, until) for of in groups]
            except ContradictionError:
                continue
            except NoTableError:
                return {}
            return {start: table for table, of in zip(learnt, groups, strict=True) for start in of}
    return {}


def decides_by_chance(world: World, budget: int, rng: Rng) -> bool:
    """Whether another seed that begins alike goes on otherwise under the same choices; what seeds hide counts too.

    Args:
        world: Where.
        budget: Steps after which no other seed is tried.
        rng: Draws seeds and choices.
    """
    if not world.is_repeated:
        return True
    if not isinstance(world.space, Discrete):
        return False
    actions, met = world.space.start + rng.integers(world.space.n, size=world.horizon), dict[str, tuple[Any, ...]]()
    until = world.taken + budget
    for start in rng.integers(*TRAINING, RESETS).tolist():
        if world.taken >= until:
            break
        shown = world.show(start, actions)
        went = tuple(map(key_of, shown.observed)), shown.paid.tobytes(), shown.ended
        if met.setdefault(key_of(shown.observed[0]), went) != went:
            return True
    return False


@dataclass(frozen=True, eq=False)
class Ways:
    """The best-paid way from each state to an end of one kind; of several, the shortest.

    Attributes:
        value: What is paid from each step on, discounted from it, (horizon + 1, states); minus infinity for no way.
        choices: The action at each step, (horizon, states).
    """

    value: Float
    choices: NDArray[np.int8]

    def actions(self, table: Table, state: int, step: int = 0) -> list[int]:
        """Those of the way from a state at a step."""
        taken = []
        while state >= 0 and step < len(self.choices):
            taken.append(int(self.choices[step, state]))
            state, step = int(table.next[state, taken[-1]]), step + 1
        return taken


def best_ways(table: Table, horizon: int, gamma: float, last: Mask, through: Mask) -> Ways:
    """The best-paid ways to an end, by dynamic programming.

    Args:
        table: What actions do.
        horizon: The steps of an episode that nothing ends.
        gamma: The discount per step.
        last: Whether a step may be the last one, (states, actions).
        through: Whether a step may be one before the last one, (states, actions).
    """
    states = len(table.next)
    value, length = np.full((horizon + 1, states), -np.inf), np.zeros((states,))
    choices = np.zeros((horizon, states), np.int8)
    goes_on, rows = through & (table.next >= 0), np.arange(states)
    ended = np.where(last, table.paid, -np.inf)
    for step in reversed(range(horizon)):
        if step == horizon - 1:
            paid, lengths = ended, np.ones_like(ended)
        else:
            after = np.where(goes_on, table.paid + gamma * value[step + 1][table.next], -np.inf)
            paid = np.where(table.next < 0, ended, after)
            lengths = np.where(table.next < 0, 1.0, 1.0 + length[table.next])
        best = paid.max(axis=1)
        with np.errstate(invalid="ignore"):  # minus infinity less itself
            close = paid >= (best - CLOSE * np.maximum(1.0, np.abs(best)))[:, None]
        choice = np.where(close, lengths, np.inf).argmin(axis=1)
        value[step], choices[step], length = best, choice, lengths[rows, choice]
    return Ways(value, choices)


def fastest_way(table: Table, begin: int, lasting: Ways, gamma: float) -> tuple[list[int], float] | None:
    """The best-paid success that is about as fast as the fastest one from a state: actions and pay; None for none.

    A success that nothing ends begins where it lasts to the horizon; before that step anything may happen.

    Args:
        table: What actions do.
        begin: The state.
        lasting: The ways that are a success at every step.
        gamma: The discount per step.
    """
    state_of, action_of = np.nonzero(table.next >= 0)
    after, paid = table.next[state_of, action_of], table.paid[state_of, action_of]
    reached, came = np.full(len(table.next), -np.inf), list[Ints]()
    reached[begin] = 0.0
    best, found, limit = -np.inf, None, math.inf
    for step in range(len(lasting.choices)):
        total = reached + gamma**step * lasting.value[step]
        state = int(total.argmax())
        if step + 1 > limit:
            break
        if total[state] > -np.inf:
            limit = min(limit, AS_FAST * (step + 1))
        if total[state] > best:
            best, found = float(total[state]), (state, step)
        gained = reached[state_of] + gamma**step * paid
        order = np.argsort(gained, kind="stable")  # of several that lead to one state the best-paid one writes last
        came.append(np.full(len(reached), -1))
        came[-1][after[order]] = order
        reached = np.full(len(reached), -np.inf)
        np.maximum.at(reached, after, gained)
    if found is None:
        return None
    state, step = found
    way = lasting.actions(table, state, step)
    for edges in reversed(came[:step]):
        way.insert(0, int(action_of[edges[state]]))
        state = int(state_of[edges[state]])
    return way, best


Best: TypeAlias = tuple[list[int], float, Data | None]
"""The best-paid episode of one kind from one start: its actions, counted from 0; their sum of pay, discounted if that
was asked; and by what is observed, the action, None if it acts differently in the same state."""


def solved(table: Table, horizon: int, gamma: float, first: int) -> Callable[[int], list[Best]]:
    """The best-paid failure, the best-paid success and the fastest one from a start, as far as there are any.

    Args:
        table: What actions do.
        horizon: The steps of an episode that nothing ends.
        gamma: The discount per step.
        first: The number of the first action, for policies.
    """
    anyhow = np.ones_like(table.success)
    failing = best_ways(table, horizon, gamma, ~table.success, anyhow)
    succeeding = best_ways(table, horizon, gamma, table.success, anyhow)
    lasting = best_ways(table, horizon, gamma, table.success, table.success)

    def policy(ways: Ways, state: int, actions: list[int]) -> Data | None:
        """Where states are few, a policy if the way is one: off it, it does what is best in the first step."""
        chosen: dict[int, int] = {}
        for action in actions:
            if chosen.setdefault(state, action) != action or not 0 < len(table.keys) <= MOST_CHOICES:
                return None
            state = int(table.next[state, action])
        choices = ways.choices[0] + first
        choices[[*chosen]] = [first + action for action in chosen.values()]
        return table_policy(table.keys, choices)

    def bests(start: int) -> list[Best]:
        begin = table.begins[start]
        found = [
            (ways, ways.actions(table, begin), float(ways.value[0, begin]))
            for ways in (failing, succeeding)
            if ways.value[0, begin] > -np.inf
        ]
        fastest = fastest_way(table, begin, lasting, gamma)
        found += [(succeeding, *fastest)] if fastest else []
        return [(actions, paid, policy(ways, begin, actions)) for ways, actions, paid in found]

    return bests


def table_policy(keys: Sequence[str], choices: NDArray[Any]) -> Data:
    """A policy as plain data: by what is observed, an action."""
    return {"kind": TABLE, "choices": dict(zip(keys, choices.tolist(), strict=True))}


def act_by_table(policy: Data) -> Act:
    """What such a policy does; where it never was, what it does most often."""
    choices = policy["choices"]
    usual = max(sorted(set(choices.values())), key=list(choices.values()).count)
    return lambda observed: choices.get(key_of(observed), usual)


def search_tables(world: World, starts: Sequence[int], keep: Keep, budget: int, rng: Rng) -> bool:
    """Look for the three numbers of each start in a table; every best episode is played and given to `keep`.

    Args:
        world: Where.
        starts: The seeds of the resets.
        keep: Takes in episodes.
        budget: About so many steps are taken at most.
        rng: Draws the random actions that a table is tried by.

    Returns:
        Whether the numbers are exact: there is a table, and its episodes are paid what it says.
    """
    tables = learn_tables(world, starts, budget, rng)
    first, are_true = int(world.space.start) if isinstance(world.space, Discrete) else 0, bool(tables)
    for gamma in dict.fromkeys((1.0, world.gamma)) if tables else ():
        bests_in = {table: solved(table, world.horizon, gamma, first) for table in dict.fromkeys(tables.values())}
        for row, start in enumerate(starts):
            best, told, policies = zip(*bests_in[tables[start]](start), strict=True)
            actions = np.full((len(best), world.horizon), first)
            for taken, way in zip(actions, best, strict=True):
                taken[: len(way)] += way
            outcomes = world.play(np.full(len(best), start), actions)
            keep(np.full(len(best), row), list(actions), outcomes, TABLE, policies)
            paid = outcomes.paid if gamma == 1.0 else outcomes.discounted
            are_true &= bool(np.allclose(paid, told, rtol=TRUE, atol=TRUE))
    return are_true
