"""What an environment must satisfy. Each check takes the environment."""

import math
import warnings
from collections.abc import Sequence
from contextlib import closing
from typing import Any

import numpy as np
from gymnasium.utils.env_checker import check_env

from harness.environment import (
    AnyEnv,
    Environment,
    baseline_of,
    bounds_of,
    goal_rewards,
    higher_is_better,
    lower_is_better,
)
from harness.errors import UsageError
from harness.experiment.environments.plan import RandomStep, random_steps, value_of
from harness.experiment.environments.spaces import ACHIEVED, DESIRED, flat_observations, goal_columns, kind_of_actions
from harness.recorder.column import Column, made_columns
from harness.reward.given import Untold

from .contract import check, require, settings_are_frozen, settings_survive_json

STEPS, LONGEST = 100, 20_000
"""The steps that are tried, and the most that an episode may take."""
Row = list[float]


@check("environment-api")
def the_env_is_one_of_gymnasium(environment: Environment) -> None:
    """The env that `make` returns passes `gymnasium.utils.env_checker.check_env`, without rendering."""
    with closing(environment.make()) as env, warnings.catch_warnings():
        warnings.simplefilter("ignore")  # advice on how spaces are best
        check_env(env, skip_render_check=True)


@check("environment-spaces")
def algorithms_can_take_it(environment: Environment) -> None:
    """Observations can be put into one row of numbers; actions are choices, or one row of numbers within bounds."""
    with closing(environment.make()) as env:
        flat_observations(env.observation_space)
        kind_of_actions(env.action_space)


@check("environment-names")
def names_are_known(environment: Environment) -> None:
    """There is a reward, `baseline` is one of them; `lower_is_better` and `bounds` name measures of behaviour alone.

    What stands under a name is a function, an object with `reset` that can be called, or the name of a number.
    """
    with closing(environment.make()) as env:
        rewards, measures = environment.rewards(env), environment.behaviour(env)
        try:
            made_columns(env, rewards, measures, 1, frozenset())
        except UsageError as error:
            raise AssertionError(str(error)) from error
    require(bool(rewards), "it names no reward")
    baseline = baseline_of(environment, rewards)
    require(baseline in rewards, f"its baseline '{baseline}' is none of its rewards {sorted(rewards)}")
    for member, named in (
        ("lower_is_better", lower_is_better(environment)),
        ("higher_is_better", higher_is_better(environment)),
        ("bounds", bounds_of(environment)),
    ):
        for name in named:
            require(name in measures, f"{member} names '{name}', which is none of the measures {sorted(measures)}")


@check("environment-directions")
def every_number_has_a_direction(environment: Environment) -> None:
    """A measure that is neither 0 nor 1 in some step stands in `lower_is_better` or in `higher_is_better`."""
    said = lower_is_better(environment) | higher_is_better(environment)
    with closing(environment.make()) as env:
        columns = made_columns(env, {}, environment.behaviour(env), 1, frozenset())
        for step in random_steps(env, 0, STEPS, columns):
            for column, value in _told(columns, step):
                name = column.name.partition("_")[2]
                number = 0.0 if value is None else _number_or_nan(column, value)
                is_known = name in said or number in {0.0, 1.0} or math.isnan(number)  # another check tells of the last
                require(is_known, f"its measure '{name}' is {number:g}, and nobody says whether less or more is better")


@check("environment-finite")
def numbers_are_finite(environment: Environment) -> None:
    """In a whole episode every reward gives a finite number for every step. So does every measure, at least at the end.

    The episode takes random actions; short ones follow one another until there are 100 steps.
    """
    with closing(environment.make()) as env:
        ended = False
        for step in random_steps(env, 0, LONGEST, columns := _columns(environment, env)):
            ended = ended or step.ended
            for column, value in _told(columns, step):
                if value is None and column.may_be_untold and not step.ended:
                    continue
                where = f"step {step.number} of an episode{', its last,' * step.ended}"
                require(value is not None, f"{column.noun} reads a key that info does not have after {where}")
                try:
                    column.numbers(value)
                except (TypeError, ValueError, UsageError) as error:
                    raise AssertionError(f"{column.noun} after {where}: {error}") from error
            if ended and step.done >= STEPS:
                return


@check("environment-seeded")
def a_seed_decides_everything(environment: Environment) -> None:
    """The same seed and the same actions give the same observations, rewards and measures, in one env and in two.

    In two episodes at least, of which the second begins without a seed.
    """
    with closing(environment.make()) as env, closing(environment.make()) as other:
        first, again, elsewhere = (_rollout(environment, it) for it in (env, env, other))
    require(np.array_equal(first, again, equal_nan=True), "an env that is reset with the same seed behaves differently")
    require(np.array_equal(first, elsewhere, equal_nan=True), "another env with the same seed behaves differently")


@check("environment-looks-on")
def rewards_change_nothing(environment: Environment) -> None:
    """Rewards and measures only look on: episodes are the same whether they are asked or not."""
    with closing(environment.make()) as env, closing(environment.make()) as other:
        asked = _rollout(environment, env)
        alone = [step.numbers for step in random_steps(other, 0, STEPS, cut_at=STEPS // 2)]
    same = all(np.array_equal(row[: len(bare)], bare) for row, bare in zip(asked, alone, strict=True))
    require(same, "an episode goes on differently when its rewards and measures are asked")


@check("environment-goals")
def rewards_of_goals_pay_as_they_do(environment: Environment) -> None:
    """Each name in `goal_rewards` is a reward, and its function pays the observed goals what the steps were paid.

    They are given all steps at once, when the env stands elsewhere. Of an environment without any nothing is asked.
    """
    with closing(environment.make()) as env:
        rewards, by_goals = environment.rewards(env), goal_rewards(environment, env)
        if not by_goals:
            return
        goal_columns(env.observation_space)
        unknown = sorted(by_goals.keys() - rewards.keys())
        require(not unknown, f"goal_rewards names {unknown}, which are none of its rewards {sorted(rewards)}")
        paid, goals = list[list[Any]](), list[list[Any]]()
        columns = made_columns(env, {name: rewards[name] for name in by_goals}, {}, 1, frozenset())
        for step in random_steps(env, 0, STEPS, columns):
            paid.append([column.numbers(value)[0] for column, value in _told(columns, step)])
            goals.append([np.array(step.seen.observation[key], float) for key in (ACHIEVED, DESIRED)])
        achieved, desired = (np.array(each) for each in zip(*goals, strict=True))
        for (name, pay), right in zip(by_goals.items(), np.array(paid, float).T, strict=True):
            found = np.asarray(pay(achieved, desired))
            require(found.shape == right.shape, f"'{name}' pays {STEPS} steps by goals with shape {found.shape}")
            off = int(np.argmax(np.abs(found - right)))
            same = np.allclose(found, right, rtol=1e-5, atol=1e-6)
            require(same, f"'{name}' paid a step {right[off]:.6g}, and by its goals alone {found[off]:.6g}")


@check("environment-ends")
def episodes_end(environment: Environment) -> None:
    """An episode of random actions ends, terminated or truncated, within 20,000 steps: evaluations wait for it."""
    with closing(environment.make()) as env:
        require(any(step.ended for step in random_steps(env, 0, LONGEST)), f"no episode ended within {LONGEST:,} steps")


def _columns(environment: Environment, env: AnyEnv) -> list[Column]:
    return made_columns(env, environment.rewards(env), environment.behaviour(env), 1, frozenset())


def _told(columns: Sequence[Column], step: RandomStep) -> list[tuple[Column, Any]]:
    """What the rewards and measures say of a step; None of a key that info does not have."""
    told: list[tuple[Column, Any]] = []
    for column in columns:
        try:
            told.append((column, value_of(column, step)))
        except Untold:
            if column.key is None:
                raise
            told.append((column, None))
    return told


def _rollout(environment: Environment, env: AnyEnv) -> list[Row]:
    """All numbers of some steps; NaN for what is not told, or is no number."""
    columns = _columns(environment, env)
    return [
        [*step.numbers, *(_number_or_nan(column, value) for column, value in _told(columns, step))]
        for step in random_steps(env, 0, STEPS, columns, cut_at=STEPS // 2)
    ]


def _number_or_nan(column: Column, value: Any) -> float:
    try:
        return column.numbers(value)[0]
    except (TypeError, ValueError, UsageError):  # another check says so
        return math.nan


ENVIRONMENT_CHECKS = (
    settings_are_frozen,
    settings_survive_json,
    the_env_is_one_of_gymnasium,
    algorithms_can_take_it,
    names_are_known,
    every_number_has_a_direction,
    numbers_are_finite,
    a_seed_decides_everything,
    rewards_change_nothing,
    rewards_of_goals_pay_as_they_do,
    episodes_end,
)
