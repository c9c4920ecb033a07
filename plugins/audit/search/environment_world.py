"""Anybody's environment as a search plays it: begun by ``reset(seed)``, moved by ``step``, paid by one reward."""

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cached_property, partial
from math import isfinite, nan
from typing import Any

import gymnasium
import numpy as np
from gymnasium.spaces import Dict, Discrete
from gymnasium.wrappers import TimeLimit

from harness import Float, Mask
from harness.environment import AnyEnv
from harness.errors import UsageError, reason_of
from harness.eta.laws import direction_of
from harness.experiment.environments.spaces import ACHIEVED, DESIRED, rows_of
from harness.log.log import SUCCESS, are_flags
from harness.record.dataset.labels import parse_success
from harness.recorder.column import Column, made_columns
from harness.recorder.env_facts import Columns
from harness.recorder.guard import Guard, Raised
from harness.registry import unknown_name
from harness.reward.given import Before, Now, Untold, told_under, zeros_of

from ..transitions.audit_rewards import opened_env
from .moves import bounds_of
from .spaces import coded
from .world import Shown, Step, World

CUT_AT = 500
"""Steps of an episode that nothing else ends."""
TOLD_BY_INFO = ("is_success", SUCCESS)
"""Keys under which envs tell success."""
SAME = 4
"""So many actions are tried over and over to see whether an env ends episodes by itself."""


class EnvironmentWorld(World):
    """One reward in one env; see `World`.

    What ``info`` does not tell in a step is NaN.
    """

    def __init__(
        self,
        env: AnyEnv,
        make: Callable[[], AnyEnv],
        columns: Callable[[AnyEnv], Columns],
        name: str,
        reward: str,
        gamma: float,
        success: str,
        horizon: int | None,
        is_new: bool = True,
    ) -> None:
        """Play a few episodes of random actions to see what an env tells.

        Args:
            env: The first one.
            make: Makes another one.
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
        self.name, self.reward, self.gamma = name, reward, gamma
        self._make, self._columns, self._is_new = make, columns, is_new
        self._coded, self.observes = coded(env.action_space, name), env.observation_space
        self.space, self._rows = self._coded.space, rows_of(self.observes)
        limit = horizon or _limit_of(env)
        self.horizon = limit or CUT_AT
        self._rule, self._more = parse_success(success), dict[str, str]()
        given = columns(env)
        both = given.lower_is_better, given.higher_is_better
        better = {it: direction_of(it, *both, is_flag=False) for it in given.behaviour}
        said = {it: 1 if of == "higher" else -1 for it, of in better.items() if of}
        if self._rule.key and self._rule.key not in given.behaviour:
            self._more = {self._rule.key: self._rule.key}
        self._drew, self._info = False, dict[str, Any]()
        self._ask(env)
        tried = self.at_random()
        self.notes = (*self._find_success(tried, said), *filter(None, [self._coded.note]))
        if not limit:
            self.horizon = self._own_limit(tried) or CUT_AT
            if self.horizon == CUT_AT:
                self.notes = (*self.notes, f"Nothing limits its episodes: they are cut after {CUT_AT} steps.")
        self.taken, self.success, key = 0, self._rule.text, self._rule.key
        self.directions = {**said, **({key: -1 if self._rule.sign.startswith("<") else 1} if key else {})}

    @cached_property
    def is_repeated(self) -> bool:
        """Whether the same comes again, and neither the reward nor a measure drew at random; see `World`."""
        return super().is_repeated and not self._drew

    def _ask(self, env: AnyEnv) -> None:
        """Ask the reward and all measures about the steps of an env, as `harness.RecordRewards` does."""
        columns = self._columns(env)
        if self.reward not in columns.rewards:
            raise UsageError(unknown_name("reward", self.reward, columns.rewards))
        behaviour = {**columns.behaviour, **self._more}
        self.measures, self._env, self._is_open = tuple(behaviour), env, True
        self._asked = made_columns(env, {self.reward: columns.rewards[self.reward]}, behaviour, 1, frozenset())
        self._functions = [it.measures[0] for it in self._asked if it.measures]
        self._of_step = [it.takes_step for it in self._asked if it.measures]
        self._is_watched = any(it.is_watched for it in self._asked)
        self._guard, self._place = Guard(), (0, 0)
        self._before: tuple[Any, ...] = ()

    def open(self, count: int = 1) -> "EnvironmentWorld":
        """Itself, which plays one episode at a time; see `World`."""
        if not self._is_open:
            self._ask(self._make())
        return self

    def close(self) -> None:
        """Close the env, unless it is somebody else's."""
        if self._is_new and self._is_open:
            self._env.close()
            self._is_open = False

    def written(self, action: Any) -> Any:
        """An action of its env as it is coded; see `World`."""
        return self._coded.encoded(action)

    @property
    def terms(self) -> Sequence[str]:  # type: ignore[override]
        """The names of the terms of the reward; none if it has none."""
        return self._asked[0].terms or ()

    def successes(self, told: Float) -> Mask:
        """By the rule that tells success; see `World`."""
        if not self._rule.key:
            return np.zeros(len(told), bool)
        values = told[:, self.measures.index(self._rule.key)]
        found: Mask = self._rule.of_steps(values, self._rule.key) == 1 if self._rule.sign else values > 0.0
        return found

    def nearest(self, shown: Shown) -> tuple[float, Sequence[Float]]:
        """By a measure that tells it, else by observed goals; see `World`."""
        directions, key, seen, rows = self.directions, self._rule.key, shown.observed, self._rows
        trails: Any = [np.array([rows.of(it) for it in seen], np.float32)] if rows.size else []
        name = key if self._rule.sign else next((it for it in directions if it != key), "")
        near = nan
        if name:
            near = float(np.fmax.reduce(shown.measures[name] * directions[name]))
        elif isinstance(self.observes, Dict) and {ACHIEVED, DESIRED} <= self.observes.keys():
            achieved, desired = (np.array([it[goal] for it in seen[1:]], np.float32) for goal in (ACHIEVED, DESIRED))
            near = -float(np.linalg.norm(achieved - desired, axis=1).min())
        return near, trails

    def reset(self, starts: list[int]) -> tuple[Any, Any]:
        seal, (start,) = self._guard.seal, starts
        observation, info = self._env.reset(seed=start)
        self._place, self._before = (start, 0), (seal(observation), None, seal(info))
        for column in self._asked:
            if column.remembers:
                try:
                    self._guard.answer(column.measures[0].reset, ())
                except Exception as error:  # whatever rewards of users raise
                    raise UsageError(f"{column.noun}: its reset() fails: {reason_of(error)}") from error
        return [observation], self._before[:1]

    def step(self, actions: Any) -> Step:
        taken: Any = np.array(actions[0], self.space.dtype)
        taken = taken.ravel() if self.space.shape else taken.item()
        action = self._coded.decoded(taken)
        observation, pays, terminated, truncated, self._info = self._env.step(action)
        # a copy of the observation; what the reward pays for the step, followed by its terms; what measures tell
        seal, (start, steps) = self._guard.seal, self._place
        kept, self._place = seal(observation), (start, steps + 1)
        forms: tuple[Any, ...] = ()
        answers: Iterator[Any] = iter(())
        if self._functions:
            (seen, last, told), given = self._before, (self._before[0], seal(action), kept, seal(self._info))
            forms = (given, ())
            if any(self._of_step):
                before = Before._make((seen, last if steps else zeros_of(given[1]), told))
                forms = given, (Now._make((kept, given[1], given[3], bool(terminated), bool(truncated), before)),)
            asking = [forms[of_step] for of_step in self._of_step]
            answers = iter(self._guard.ask(self._functions, asking, is_watched=self._is_watched))
            self._drew, self._before = self._drew or bool(self._guard.drew), (kept, given[1], given[3])
        values = [next(answers) if it.measures else pays for it in self._asked]
        paid, *measured = (self._numbers(*it, forms) for it in zip(self._asked, values, strict=True))
        ended = {0: "terminated" if terminated else "truncated"} if terminated or truncated else {}
        return Step([taken], [observation], [kept], [paid], [[it[0] for it in measured]], ended)

    def _own_limit(self, tried: Sequence[Shown]) -> int:
        """After how many steps an env ends episodes that says so nowhere; 0 where none tells.

        The longest ones, of random actions or of the same action over and over, are truncated then. Or, as envs say
        ``terminated`` there too, most are as long as the longest.
        """
        space, played = self.space, list(tried)
        same = (
            space.start + np.arange(space.n)[:SAME]
            if isinstance(space, Discrete)
            else [np.clip(np.zeros(space.shape), *bounds_of(space))]
        )
        for start, action in itertools.product(range(2), same):
            played += self.episodes(np.array([start]), lambda *_, action=action: [action])
        longest = [it for it in played if len(it.paid) == max(len(it.paid) for it in played)]
        is_truncated = len(longest) > 1 and all(it.ended == "truncated" for it in longest)
        is_limit = is_truncated or len(longest) > max(2, len(played) / 2)
        return len(longest[0].paid) if is_limit else 0

    def _find_success(self, tried: Sequence[Shown], directions: Mapping[str, int]) -> tuple[str, ...]:
        """Find what tells success if the user did not say; returns what there is to tell of it."""
        told = {name: np.concatenate([it.measures[name] for it in tried]) for name in self.measures}
        info, key = self._info, self._rule.key
        if key:
            if self._more and np.isnan(told[key]).all():
                there = {*told, *info} - {key}
                raise UsageError(f"success '{self._rule.text}': {unknown_name('measure', key, there)}")
            return ()
        flags = (name for name, values in told.items() if _is_flag(values) and directions.get(name) != -1)
        found = SUCCESS if SUCCESS in told else next(flags, "")
        if found:
            self._rule = parse_success(found)
            return () if found == SUCCESS else (f"{found}, which is 0 or 1, is taken for success.",)
        key = next((it for it in TOLD_BY_INFO if it in info and _is_flag(np.array([info[it]], float))), "")
        if not key:
            return ()
        self._rule, self._more = parse_success(key), {key: key}
        self._ask(self._env)
        return (f"No measure says what success is: {key} is taken, which the environment tells in info.",)

    def _numbers(self, column: Column, value: Any, forms: tuple[Any, ...]) -> list[float]:
        """The number of a column, followed by a reward's terms; NaN for a measure that info does not tell."""
        key = column.key
        if key is None and type(value) is float and isfinite(value) and not column.terms:  # mostly a call less
            return [value]
        error = value.error if isinstance(value, Raised) else None
        try:
            if error is None:
                if key is not None:
                    value = told_under(self._info, key)
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
    return len(told) > 0 and are_flags(told)


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
    made, make = opened_env(env), partial(opened_env, env)
    name = made.spec.id if made.spec is not None else type(made.unwrapped).__name__
    return EnvironmentWorld(made, make, lambda _: columns, name, reward, gamma, success, None, made is not env)
