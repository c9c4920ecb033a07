"""Anybody's environment as a search plays it: begun by ``reset(seed)``, moved by ``step``, paid by one reward."""

import itertools
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from dataclasses import replace
from functools import cached_property
from math import isfinite, nan
from typing import Any, NamedTuple, TypeAlias

import gymnasium
import numpy as np
from gymnasium.spaces import Box, Discrete, flatten
from gymnasium.wrappers import TimeLimit

from harness.arrays import Float, Ints, Mask
from harness.authoring.commands import (
    Before,
    Column,
    Columns,
    Guard,
    Now,
    Raised,
    Untold,
    flat_observation,
    flat_observations,
    goal_columns,
    kind_of_actions,
    made_columns,
    parse_success,
    told_under,
    zeros_of,
)
from harness.environment import AnyEnv
from harness.errors import UsageError, reason_of
from harness.log import SUCCESS, episode_sum
from harness.registry import unknown_name

from ..transitions.audit_rewards import opened_env
from .world import Act, Actions, Outcomes, Shown, Space, since

CUT_AT = 500
"""Steps of an episode that nothing else ends."""
TOLD_BY_INFO = ("is_success", SUCCESS)
"""Keys under which envs tell success."""
SAME = 4
"""So many actions are tried over and over to see whether an env ends episodes by itself."""
TRIED = 3
"""Episodes of random actions that are played first: to see which measures are flags, and whether they are repeated."""
REWARD = "reward"
Choose: TypeAlias = Callable[[int, Any], Any]
"""From the number of a step, from 0, and the observation before it to an action."""


class _Played(NamedTuple):
    """One episode: the actions as `World` has them, and by step what it paid, with terms, and what measures told."""

    start: int
    actions: list[Any]
    paid: list[list[float]]
    told: list[list[float]]
    seen: list[Any]
    ended: str
    info: Mapping[str, Any]


class EnvironmentWorld:
    """One reward in one env; see `World`.

    Boxes of actions that have other shapes than one row are flat here. What ``info`` does not tell in a step is NaN.
    """

    together = 1

    def __init__(
        self,
        make: Callable[[], AnyEnv],
        columns: Callable[[AnyEnv], Columns],
        name: str,
        reward: str,
        gamma: float,
        success: str,
        horizon: int | None,
        is_new: bool = True,
    ) -> None:
        """Make an env, and play a few episodes of random actions to see what it tells.

        Args:
            make: Makes an env.
            columns: Its rewards and measures.
            name: What it is called.
            reward: The name of the reward.
            gamma: The learner's discount per step.
            success: What tells success, as a user types it, ``height>0.9``; empty to find a measure that does.
            horizon: Steps after which an episode is cut; None for the env's own limit, else `CUT_AT`.
            is_new: Whether `make` makes a new env at every call, which is closed when it is not needed any more.

        Raises:
            UsageError: Its actions cannot be searched, a name is not known, or the reward or a measure fails.
        """
        self.name, self.reward, self.gamma, self.taken = name, reward, gamma, 0
        self._make, self._columns, self._is_new, self._env = make, columns, is_new, make()
        self.space, self.observes = _flat_space(self._env, name), self._env.observation_space
        flat_observations(self.observes)
        self._goals: tuple[slice, slice] | None = None  # where achieved and desired goals stand in flat observations
        with suppress(UsageError):
            self._goals = goal_columns(self.observes)
        limit = horizon or _limit_of(self._env)
        self.horizon = limit or CUT_AT
        self._rule, self._more = parse_success(success), dict[str, str]()
        given = columns(self._env)
        higher, lower = dict.fromkeys(given.higher_is_better, 1), dict.fromkeys(given.lower_is_better, -1)
        self._direction_of = {**higher, **lower}
        if self._rule.key and self._rule.key not in given.behaviour:
            self._more = {self._rule.key: self._rule.key}
        self._asked = self._asking(self._env)
        self._tried = self._try(self._asked)
        self.notes: Sequence[str] = self._find_success()
        if not limit:
            self.horizon = self._own_limit() or CUT_AT
            if self.horizon == CUT_AT:
                self.notes = (*self.notes, f"Nothing limits its episodes: they are cut after {CUT_AT} steps.")

    def _own_limit(self) -> int:
        """After how many steps an env ends episodes that says so nowhere; 0 where none tells.

        The longest ones, of random actions or of the same action over and over, are truncated then. Or, as envs say
        ``terminated`` there too, most are as long as the longest.
        """
        space, played = self.space, list(self._tried)
        same = (
            space.start + np.arange(space.n)[:SAME]
            if isinstance(space, Discrete)
            else [np.clip(np.zeros(space.shape), space.low, space.high)]
        )
        for start, action in itertools.product(range(2), same):
            played.append(self._episode(self._asked, start, lambda *_, action=action: action))
        longest = [it for it in played if len(it.actions) == max(len(it.actions) for it in played)]
        is_truncated = len(longest) > 1 and all(it.ended == "truncated" for it in longest)
        is_limit = is_truncated or len(longest) > max(2, len(played) / 2)
        return len(longest[0].actions) if is_limit else 0

    @property
    def success(self) -> str:
        """What tells success, as a user types it; empty if nothing does."""
        return self._rule.text

    @cached_property
    def directions(self) -> Mapping[str, int]:
        """Those of the measures of which somebody said it, 1 where more is better; and what success says."""
        found = {name: self._direction_of[name] for name in self._asked.measures if name in self._direction_of}
        return {**found, self._rule.key: -1 if self._rule.sign.startswith("<") else 1} if self._rule.key else found

    @cached_property
    def is_repeated(self) -> bool:
        """Whether the same comes again in this env, in another order, and in a new one if one can be made."""
        again = self._try(self._asked, reversed(range(TRIED)))[::-1]
        if not self._is_new:
            return not self._asked.drew and all(map(self._is_same, self._tried, again))
        env = self._make()
        try:
            anew = self._try(self._asking(env))
        finally:
            env.close()
        pairs = [*zip(self._tried, again, strict=True), *zip(self._tried, anew, strict=True)]
        return not self._asked.drew and all(self._is_same(one, other) for one, other in pairs)

    def play(self, starts: Ints, actions: Actions) -> Outcomes:
        """Play n episodes of given actions; see `World`."""
        return self._outcomes([
            self._counted(start, lambda step, _, given=given: given[step])  # type: ignore[misc]
            for start, given in zip(starts.tolist(), actions, strict=True)
        ])  # fmt: skip

    def act(self, starts: Ints, policy: Act) -> tuple[Outcomes, list[Actions]]:
        """Play n episodes of a policy; see `World`."""
        played = [self._counted(start, lambda _, seen: policy(seen)) for start in starts.tolist()]
        return self._outcomes(played), [np.array(it.actions, self.space.dtype) for it in played]

    def show(self, start: int, actions: Actions) -> Shown:
        """Play one episode and keep everything; see `World`."""
        return self._shown(self._counted(start, lambda step, _: actions[step], len(actions)))

    def watch(self, start: int, policy: Act) -> Shown:
        """Play one episode of a policy and keep everything; see `World`."""
        return self._shown(self._counted(start, lambda _, seen: policy(seen)))

    def _shown(self, played: _Played) -> Shown:
        paid, told = np.array(played.paid), np.array(played.told)
        terms = {name: paid[:, 1 + k] for k, name in enumerate(self._asked.columns[0].terms or ())}
        return Shown(
            played.start,
            np.array(played.actions, self.space.dtype),
            paid[:, 0],
            terms or {REWARD: paid[:, 0]},
            self._successes(told),
            {name: told[:, k] for k, name in enumerate(self._asked.measures)},
            played.ended,
            tuple(played.seen),
        )

    def close(self) -> None:
        """Close the env, unless it is somebody else's."""
        if self._is_new:
            self._env.close()

    def _asking(self, env: AnyEnv) -> "_Asked":
        columns = self._columns(env)
        if self.reward not in columns.rewards:
            raise UsageError(unknown_name("reward", self.reward, columns.rewards))
        return _Asked(env, replace(columns, behaviour={**columns.behaviour, **self._more}), self.reward)

    def _try(self, asked: "_Asked", starts: Iterable[int] = range(TRIED)) -> list[_Played]:
        """Episodes of random actions."""
        played = []
        for start in starts:
            self.space.seed(start)
            played.append(self._episode(asked, start, lambda *_: self.space.sample()))
        return played

    def _find_success(self) -> tuple[str, ...]:
        """Find what tells success if the user did not say; returns what there is to tell of it."""
        told = np.concatenate([np.array(it.told).reshape(len(it.told), -1) for it in self._tried])
        names, info = self._asked.measures, self._tried[0].info
        if self._rule.key:
            if self._more and np.isnan(told[:, names.index(self._rule.key)]).all():
                there = {*names, *info} - {self._rule.key}
                raise UsageError(f"success '{self._rule.text}': {unknown_name('measure', self._rule.key, there)}")
            return ()
        flags = [name for name, values in zip(names, told.T, strict=True) if _is_flag(values)]
        found = SUCCESS if SUCCESS in names else next((it for it in flags if self._direction_of.get(it) != -1), "")
        if found:
            self._rule = parse_success(found)
            return () if found == SUCCESS else (f"{found}, which is 0 or 1, is taken for success.",)
        key = next((it for it in TOLD_BY_INFO if it in info and _is_flag(np.array([info[it]], float))), "")
        if not key:
            return ()
        self._rule, self._more = parse_success(key), {key: key}
        self._asked = self._asking(self._env)
        self._tried = self._try(self._asked)
        return (f"No measure says what success is: {key} is taken, which the environment tells in info.",)

    def _counted(self, start: int, choose: Choose, most: int | None = None) -> _Played:
        played = self._episode(self._asked, start, choose, most)
        self.taken += len(played.actions)
        return played

    def _episode(self, asked: "_Asked", start: int, choose: Choose, most: int | None = None) -> _Played:
        """Play an episode of at most so many steps."""
        env, space = asked.env, self.space
        is_discrete, kind = isinstance(space, Discrete), space.dtype
        observation, info = env.reset(seed=start)
        seen, actions, paid, told = [asked.begin(start, observation, info)], list[Any](), list[Any](), list[Any]()
        ended = ""
        for step in range(min(self.horizon, most or self.horizon)):
            chosen = choose(step, observation)
            action = int(chosen) if is_discrete else np.array(chosen, kind).reshape(env.action_space.shape)
            actions.append(action if is_discrete else action.ravel().copy())  # type: ignore[union-attr]
            observation, pays, terminated, truncated, info = env.step(action)
            ended = "terminated" if terminated else "truncated" if truncated else ""
            kept, numbers, measures = asked.tell(action, observation, pays, info)
            seen.append(kept)
            paid.append(numbers)
            told.append(measures)
            if ended:
                break
        return _Played(start, actions, paid, told, seen, ended or "cut", info)

    def _outcomes(self, played: Sequence[_Played]) -> Outcomes:
        told = [np.array(it.told).reshape(len(it.told), -1) for it in played]
        paid = [np.array([row[0] for row in it.paid]) for it in played]
        success = [self._successes(values) for values in told]
        last, trails = np.array([values[-1] for values in told]), [_flat(self.observes, it.seen) for it in played]
        return Outcomes(
            np.array([len(it.actions) for it in played]),
            np.array([episode_sum(values) for values in paid]),
            np.array([episode_sum(values, self.gamma) for values in paid]),
            np.array([flags[-1] for flags in success]),
            np.array([since(flags) if flags[-1] else self.horizon for flags in success]),
            np.array([flags.mean() for flags in success]),
            np.array([self._nearest(*it) for it in zip(told, trails, strict=True)]),
            {name: last[:, k] for k, name in enumerate(self._asked.measures)},
            trails,
        )

    def _successes(self, told: Float) -> Mask:
        """Whether each step was a success, (steps,), from what measures told, (steps, measures)."""
        if not self._rule.key:
            return np.zeros(len(told), bool)
        values = told[:, self._asked.measures.index(self._rule.key)]
        found: Mask = self._rule.of_steps(values, self._rule.key) == 1 if self._rule.sign else values > 0.0
        return found

    def _nearest(self, told: Float, trail: Float) -> float:
        """How near an episode came to success; larger is nearer. Without a measure that tells it, to observed goals."""
        directions, key = self.directions, self._rule.key
        name = key if self._rule.sign else next((it for it in directions if it != key), "")
        if name:
            return float(np.fmax.reduce(told[:, self._asked.measures.index(name)] * directions[name]))
        if self._goals is None:
            return nan
        achieved, desired = self._goals
        return -float(np.linalg.norm(trail[1:, achieved] - trail[1:, desired], axis=1).min())

    def _is_same(self, one: _Played, other: _Played) -> bool:
        """Whether two episodes are the same, bit for bit."""
        if (one.ended, len(one.actions)) != (other.ended, len(other.actions)):
            return False
        numbers = [np.array(getattr(it, name)).tobytes() for name in ("actions", "paid", "told") for it in (one, other)]
        return numbers[::2] == numbers[1::2] and all(
            np.asarray(flatten(self.observes, a)).tobytes() == np.asarray(flatten(self.observes, b)).tobytes()
            for a, b in zip(one.seen, other.seen, strict=True)
        )


class _Asked:
    """Asks a reward and measures about the steps of one env, as `harness.RecordRewards` does.

    Attributes:
        env: That env.
        columns: The reward's, then those of the measures.
        measures: Their names.
        drew: Whether one of them drew from a generator that the whole process shares.
    """

    def __init__(self, env: AnyEnv, columns: Columns, reward: str) -> None:
        self.env = env
        self.columns = made_columns(env, {reward: columns.rewards[reward]}, columns.behaviour, 1, frozenset())
        self.measures, self.drew = tuple(columns.behaviour), False
        self._functions = [it.measures[0] for it in self.columns if it.measures]
        self._of_step = [it.takes_step for it in self.columns if it.measures]
        self._is_watched = any(it.is_watched for it in self.columns)
        self._guard, self._place = Guard(), (0, 0)
        self._before: tuple[Any, ...] = ()

    def begin(self, start: int, observation: Any, info: Any) -> Any:
        """Begin an episode; returns a copy of the observation."""
        seal = self._guard.seal
        self._place, self._before = (start, 0), (seal(observation), None, seal(info))
        for column in self.columns:
            if column.remembers:
                try:
                    self._guard.answer(column.measures[0].reset, ())
                except Exception as error:  # whatever rewards of users raise
                    raise UsageError(f"{column.noun}: its reset() fails: {reason_of(error)}") from error
        return self._before[0]

    def tell(self, action: Any, observation: Any, pays: Any, info: Any) -> tuple[Any, list[float], list[float]]:
        """A copy of the observation; what the reward pays for the step, followed by its terms; what measures tell."""
        seal, (start, step) = self._guard.seal, self._place
        kept, self._place = seal(observation), (start, step + 1)
        forms: tuple[Any, ...] = ()
        answers: Iterator[Any] = iter(())
        if self._functions:
            (seen, last, told), given = self._before, (self._before[0], seal(action), kept, seal(info))
            forms = (given, ())
            if any(self._of_step):
                before = Before._make((seen, last if step else zeros_of(given[1]), told))
                forms = given, (Now._make((kept, given[1], given[3], before)),)
            asking = [forms[of_step] for of_step in self._of_step]
            answers = iter(self._guard.ask(self._functions, asking, is_watched=self._is_watched))
            self.drew, self._before = self.drew or bool(self._guard.drew), (kept, given[1], given[3])
        values = [next(answers) if it.measures else pays for it in self.columns]
        numbers = [self._numbers(*it, info, forms) for it in zip(self.columns, values, strict=True)]
        return kept, numbers[0], [it[0] for it in numbers[1:]]

    def _numbers(self, column: Column, value: Any, info: Any, forms: tuple[Any, ...]) -> list[float]:
        """The number of a column, followed by a reward's terms; NaN for a measure that info does not tell."""
        key = column.key
        if key is None and type(value) is float and isfinite(value) and not column.terms:  # mostly a call less
            return [value]
        error = value.error if isinstance(value, Raised) else None
        try:
            if error is None:
                if key is not None:
                    value = told_under(info, key)
                return column.numbers(value)
        except Exception as raised:  # whatever rewards of users return
            error = raised
        is_nan = key is not None and isinstance(value, float | np.floating) and bool(np.isnan(value))
        if (isinstance(error, Untold) or is_nan) and column.may_be_untold:  # some envs tell NaN until an episode ends
            return [nan]
        start, step = self._place
        function = column.measures[0] if column.measures else None
        told = self._guard.reason(function, forms[column.takes_step], error) if function else reason_of(error)
        raise UsageError(f"{column.noun} failed in the episode of start {start}, step {step}: {told}") from error


def _flat_space(env: AnyEnv, name: str) -> Space:
    """The space of actions as a search has it.

    Raises:
        UsageError: Such actions cannot be searched.
    """
    space: Any = env.action_space
    if isinstance(space, Box) and len(space.shape) != 1:
        space = Box(space.low.ravel(), space.high.ravel(), dtype=space.dtype)
    try:
        kind_of_actions(space)
    except UsageError as error:
        raise UsageError(f"{name} cannot be searched: {error}") from error
    found: Space = space
    return found if found is not env.action_space else deepcopy(found)


def _limit_of(env: AnyEnv) -> int:
    """After how many steps the env itself ends an episode; 0 where nothing says that."""
    while isinstance(env, gymnasium.Wrapper):
        if isinstance(env, TimeLimit):
            return int(env._max_episode_steps)
        env = env.env
    return (env.spec and env.spec.max_episode_steps) or 0


def _is_flag(values: Float) -> bool:
    """Whether values, (steps,), of which some may be untold, are 0 or 1."""
    told = values[~np.isnan(values)]
    return len(told) > 0 and bool(np.isin(told, (0.0, 1.0)).all())


def _flat(space: gymnasium.Space[Any], seen: Sequence[Any]) -> Any:
    """Observations in rows, (n, size)."""
    if isinstance(space, Box):
        return np.asarray(seen, np.float32).reshape(len(seen), -1)
    return np.stack([flat_observation(space, it) for it in seen])


def of_env(
    env: AnyEnv | str | Callable[[], AnyEnv],
    reward: str,
    columns: Columns,
    gamma: float,
    success: str = "",
) -> EnvironmentWorld:
    """A reward in an env that somebody made, which is left open; in the env of an id; or in those of a function.

    Args:
        env: See above.
        reward: One of `columns`.
        columns: Rewards and measures.
        gamma: The learner's discount per step.
        success: What tells success, as a user types it; empty to find a measure that does.

    Raises:
        UsageError: See `EnvironmentWorld`.
    """
    made = opened_env(env)
    first = [made]

    def make() -> AnyEnv:
        return first.pop() if first else opened_env(env)

    name = made.spec.id if made.spec is not None else type(made.unwrapped).__name__
    return EnvironmentWorld(make, lambda _: columns, name, reward, gamma, success, None, made is not env)
