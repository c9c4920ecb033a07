"""What an environment must satisfy. Each check takes the environment."""

import math
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import closing
from typing import Any

import numpy as np
from gymnasium.utils.env_checker import check_env

from harness.environment import AnyEnv, Environment, Measure, baseline_of, goal_rewards, lower_is_better
from harness.experiment.environments.spaces import (
    ACHIEVED,
    DESIRED,
    flat_observation,
    flat_observations,
    goal_columns,
    kind_of_actions,
)
from harness.testing.violations import Check, check, raise_first, require, settings_are_frozen, settings_survive_json

STEPS, LONGEST = 100, 20_000
"""That are tried, and that an episode may take."""
OWN = "own"
Row = list[float]


def check_environment(environment: Environment) -> None:
    """Run all `ENVIRONMENT_CHECKS`.

    Raises:
        ContractViolation: At the first check that fails.
    """
    raise_first(ENVIRONMENT_CHECKS, environment)


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
    """There is a reward, `baseline` is one of them, and `lower_is_better` names measures of behaviour alone."""
    with closing(environment.make()) as env:
        rewards, measures = environment.rewards(env), environment.behaviour(env)
    require(bool(rewards), "it names no reward")
    baseline = baseline_of(environment, rewards)
    require(baseline in rewards, f"its baseline '{baseline}' is none of its rewards {sorted(rewards)}")
    for name in lower_is_better(environment):
        require(name in measures, f"lower_is_better names '{name}', which is none of the measures {sorted(measures)}")


@check("environment-finite")
def numbers_are_finite(environment: Environment) -> None:
    """Every reward gives a finite number for every step. So does every measure, at least at the end of an episode."""
    with closing(environment.make()) as env:
        rewards, measures = environment.rewards(env), environment.behaviour(env)
        for step in _steps(env, 0, STEPS):
            for name, value in step.values(rewards).items():
                require(value is not None, f"the reward '{name}' reads a key that info does not have")
                require(math.isfinite(value or 0.0), f"the reward '{name}' is {value} after a random step")
            for name, value in step.values(measures).items():
                untold = value is None and not step.ended
                require(untold or value is not None, f"the measure '{name}' is not told where an episode ends")
                require(math.isfinite(value or 0.0), f"the measure '{name}' is {value} after a random step")


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
        alone = [step.numbers for step in _steps(other, 0, STEPS, cut_at=STEPS // 2)]
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
        asked = {name: rewards[name] for name in by_goals}
        paid, goals = list[dict[str, Any]](), list[list[Any]]()
        for step in _steps(env, 0, STEPS):
            paid.append(step.values(asked))
            goals.append([np.array(step.after[key], float) for key in (ACHIEVED, DESIRED)])
        achieved, desired = (np.array(each) for each in zip(*goals, strict=True))
        for name, pay in by_goals.items():
            found, right = np.asarray(pay(achieved, desired)), np.array([one[name] for one in paid], float)
            require(found.shape == right.shape, f"'{name}' pays {STEPS} steps by goals with shape {found.shape}")
            off = int(np.argmax(np.abs(found - right)))
            same = np.allclose(found, right, rtol=1e-5, atol=1e-6)
            require(same, f"'{name}' paid a step {right[off]:.6g}, and by its goals alone {found[off]:.6g}")


@check("environment-ends")
def episodes_end(environment: Environment) -> None:
    """An episode of random actions ends, terminated or truncated, within 20,000 steps: evaluations wait for it."""
    with closing(environment.make()) as env:
        require(any(step.ended for step in _steps(env, 0, LONGEST)), f"no episode ended within {LONGEST:,} steps")


class _Step:
    """One step of an env, and what was before it."""

    def __init__(self, space: Any, before: Any, action: Any, told: tuple[Any, ...]) -> None:
        self._before, self._action = before, action
        self.after, self.paid, terminated, truncated, self._info = told
        self.ended = bool(terminated or truncated)
        self.numbers: Row = [*flat_observation(space, self.after).tolist(), float(self.paid)]

    def values(self, measures: Mapping[str, Measure]) -> dict[str, float | None]:
        """By name; None of a key that info does not have."""
        return {name: self._value(measure) for name, measure in measures.items()}

    def _value(self, measure: Measure) -> float | None:
        if isinstance(measure, str):
            told = self.paid if measure == OWN else self._info.get(measure)
            return None if told is None else float(told)
        return float(measure(self._before, self._action, self.after, self._info))


def _steps(
    env: AnyEnv, seed: int, count: int, on_start: Callable[[], None] = lambda: None, cut_at: int = 0
) -> Iterator[_Step]:
    """So many steps of random actions, in as many episodes as that takes; after `cut_at` steps another one begins."""
    before, _ = env.reset(seed=seed)
    on_start()
    env.action_space.seed(seed)
    for done in range(1, count + 1):
        action = env.action_space.sample()
        told = env.step(action)
        step = _Step(env.observation_space, before, action, told)
        yield step
        before = told[0]
        if step.ended or done == cut_at:
            before, _ = env.reset()
            on_start()


def _rollout(environment: Environment, env: AnyEnv) -> list[Row]:
    """All numbers of some steps; NaN for what is not told."""
    measures = {f"reward {name}": it for name, it in environment.rewards(env).items()}
    measures |= {f"measure {name}": it for name, it in environment.behaviour(env).items()}

    def start() -> None:
        for measure in measures.values():
            if callable(reset := getattr(measure, "reset", None)):
                reset()

    return [
        [*step.numbers, *(math.nan if value is None else value for value in step.values(measures).values())]
        for step in _steps(env, 0, STEPS, start, cut_at=STEPS // 2)
    ]


ENVIRONMENT_CHECKS: tuple[Check, ...] = (
    settings_are_frozen,
    settings_survive_json,
    the_env_is_one_of_gymnasium,
    algorithms_can_take_it,
    names_are_known,
    numbers_are_finite,
    a_seed_decides_everything,
    rewards_change_nothing,
    rewards_of_goals_pay_as_they_do,
    episodes_end,
)
