"""Looks at an environment before anything runs: its rewards, and which algorithms can train in it.

What is recorded of an env: the environment's own rewards and measures, and those that the user gave as files; and what
these say of each step of random actions.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import chdir, closing
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, NamedTuple

from harness.algorithm import ActionSpace, Algorithm, needs_arm, needs_goals
from harness.environment import (
    SUCCESS,
    AnyEnv,
    Environment,
    baseline_of,
    bounds_of,
    goal_rewards,
    higher_is_better,
    lower_is_better,
    rewards_of,
)
from harness.errors import UsageError, reason_of
from harness.eta.interval import UNBOUNDED
from harness.eta.laws import direction_of, may_be_flag, require_direction
from harness.experiment.environments.spaces import flat_observations, goal_columns, kind_of_actions, rows_of
from harness.recorder.column import Column, for_env, made_columns
from harness.recorder.env_facts import Columns
from harness.recorder.guard import Guard
from harness.recorder.trial import FIRST_STEPS
from harness.registry.choice import Choice, Registry, choose, label_of, parse
from harness.registry.measure_functions import EPISODE
from harness.registry.spec import PLANNED, unknown_name
from harness.registry.step_functions import StepFunction
from harness.reward import Steps
from harness.reward.forms import STEP
from harness.reward.given import ARM, Before, Given, Now, OfArm, Terms, opened, told_under, weights_of, zeros_of


class RandomStep(NamedTuple):
    """One step of an env.

    Attributes:
        done: Steps up to and with this one, in all episodes.
        number: Of this step in its episode, from 1.
        seen: It as functions are given it, `harness.reward.given.Now`: copies that nobody can write into.
        paid: What it paid.
        ended: Whether the episode ended with it.
        numbers: The observation in one row, and what the env paid.
        guard: Asks rewards and measures about it.
    """

    done: int
    number: int
    seen: Steps
    paid: Any
    ended: bool
    numbers: list[float]
    guard: Guard


def random_steps(
    env: AnyEnv, seed: int, count: int, columns: Sequence[Column] = (), cut_at: int = 0
) -> Iterator[RandomStep]:
    """So many steps of random actions, in as many episodes as that takes.

    Rewards and measures with a memory are begun with each episode. Ask them by `value_of` before the next step.

    Args:
        env: Makes the steps.
        seed: Of the first episode and of the actions.
        count: How many steps.
        columns: The rewards and measures.
        cut_at: After so many steps another episode begins.
    """
    guard, rows = Guard(), rows_of(env.observation_space)
    before, number = _begin(env, columns, guard, seed), 0
    env.action_space.seed(seed)
    for done in range(1, count + 1):
        action, number = env.action_space.sample(), number + 1
        observation, paid, terminated, truncated, info = env.step(action)
        ended, sealed = bool(terminated or truncated), map(guard.seal, (observation, action, info))
        if number == 1:
            before = before._replace(action=zeros_of(guard.seal(action)))
        seen = Now._make((*sealed, bool(terminated), bool(truncated), before))
        numbers = [*rows.of(seen.observation).tolist(), float(paid)]
        yield RandomStep(done, number, seen, paid, ended, numbers, guard)
        before = Before._make(seen[:3])
        if ended or done == cut_at:
            before, number = _begin(env, columns, guard), 0


def value_of(column: Column, step: RandomStep) -> Any:
    """What a reward or a measure says of a step, as it says it.

    Raises:
        Untold: It is a key that info does not have.
    """
    if column.is_own:
        return step.paid
    if column.key is not None:
        return told_under(step.seen.info, column.key)
    return step.guard.answer(column.measures[0], column.arguments(step.seen))


def _begin(env: AnyEnv, columns: Sequence[Column], guard: Guard, seed: int | None = None) -> Steps:
    """Begin an episode; returns what there is before its first step, whose action is not known yet."""
    observation, info = env.reset(seed=seed)
    for column in columns:
        if column.remembers:
            guard.answer(column.measures[0].reset, ())
    return Before._make((guard.seal(observation), None, guard.seal(info)))


def closest_distance(step: Steps) -> float:
    """How near the episode of an arm has come to its target, [m]."""
    return float(min(step.info[ARM].previous_best[0], *step.info[ARM].distance))


def ground_hits(step: Steps) -> bool:
    """Whether the step of an arm touched the ground."""
    return bool(step.info[ARM].ground.any())


ARM_MEASURES: Mapping[str, Given] = MappingProxyType(
    {
        SUCCESS: "is_success",
        "final_distance": "distance",
        "closest_distance": closest_distance,
        "ground_hits": ground_hits,
    }
)
"""Measures of an arm that the last step of an episode tells. Of all but success less is better."""


def columns_of(environment: Environment, env: AnyEnv, registry: Registry, named: Iterable[Choice] = ()) -> Columns:
    """What is recorded of one env of an environment: this is where the name of a reward gets its meaning there.

    The measure called ``success`` decides, else the first one that the user gave, else the environment's first.

    Args:
        environment: The environment.
        env: The env. One of an arm is measured as an arm, and an arm's rewards can pay it.
        registry: The plugins.
        named: Rewards to have beside those of the environment and of files: with weights of their terms, or an arm's.

    Raises:
        UsageError: The environment has no reward, or two of these have one name.
    """
    rewards, measures = registry.functions_of("reward"), registry.functions_of("measure")
    of_arm = ARM_MEASURES if env.metadata.get(ARM) else {}
    own, own_behaviour = rewards_of(environment, env), {**of_arm, **environment.behaviour(env)}
    _require_other_names(rewards, own)
    _require_other_names(measures, own_behaviour)
    for it in measures.values():
        if it.is_of_episodes:
            raise UsageError(
                f"Plugin file '{it.file.path}': the measure '{it.name}' takes ({EPISODE}), and whole episodes are "
                f"measured of an arm alone. In an environment write {it.name}({STEP}): the last step counts"
            )
    behaviour = {**_made(measures), **own_behaviour}
    given = {name: for_env(env, it) for name, it in {**own, **_made(rewards)}.items()}
    return Columns(
        {**given, **{it.label: _named(it, given, env, registry) for it in named}},
        {**{name: behaviour[name] for name in behaviour if name == SUCCESS}, **behaviour},
        {*of_arm.keys() - {SUCCESS}, *lower_is_better(environment), *_better(measures, "lower")},
        {*higher_is_better(environment), *_better(measures, "higher")},
        {
            **bounds_of(environment),
            **{it.name: it.bounds for it in measures.values() if it.bounds != UNBOUNDED},
        },
    )


def _named(choice: Choice, given: Mapping[str, Given], env: AnyEnv, registry: Registry) -> Given:
    """A reward of the environment, perhaps with weights of its terms; else the arm's of that name."""
    if choice.name not in given:
        if not env.metadata.get(ARM):
            raise UsageError(unknown_name("reward", choice.name, given))
        return OfArm(choice.build(registry, "rewards"))
    own, weights = given[choice.name], choice.named
    return Terms({choice.name: opened(own, f"reward {choice.name!r}")}, weights) if weights else own


def _made(functions: Mapping[str, StepFunction]) -> dict[str, Given]:
    return {name: it.make() for name, it in functions.items()}


def _better(measures: Mapping[str, StepFunction], direction: str) -> list[str]:
    return [name for name, it in measures.items() if it.better == direction]


def _require_other_names(given: Mapping[str, StepFunction], own: Mapping[str, Given]) -> None:
    for name in given.keys() & own.keys():
        it = given[name]
        raise UsageError(
            f"Plugin file '{it.file.path}': the environment has a {it.noun} '{name}' of its own. Rename yours"
        )


Named = str | Mapping[str, Any]
"""A reward as users name it."""


@dataclass(frozen=True)
class Looked:
    """What an env of an environment showed.

    Attributes:
        label: Of the environment.
        rewards: Names: the environment's own in its order, then those of files that the user gave.
        measures: Names of the measures of behaviour, the one that decides first.
        baseline: The one that the others are compared with, where the user names none.
        actions: Their kind; None where no algorithm takes them.
        unusable: Why no algorithm can train in it; empty if some can.
        goal_rewards: Names of the rewards that are functions of goals alone.
        goalless: Why no reward can be paid again for other goals; empty if observations tell of goals.
        is_arm: Whether its env tells the steps of an arm, so that an arm's rewards pay them too.
        environment: The environment.
        registry: The plugins.
    """

    label: str
    rewards: tuple[str, ...]
    measures: tuple[str, ...]
    baseline: str
    actions: ActionSpace | None
    unusable: str
    goal_rewards: frozenset[str]
    goalless: str
    is_arm: bool
    environment: Environment
    registry: Registry

    def why_not_in_hindsight(self, reward: str) -> str:
        """Why steps that are paid by a reward cannot be paid again for other goals; empty if they can."""
        if self.goalless or reward in self.goal_rewards:
            return self.goalless
        others = f"; these are: {', '.join(sorted(self.goal_rewards))}" if self.goal_rewards else ""
        return f"the reward '{reward}' is not known to depend on the goals alone{others}"

    def rewards_asked(
        self, baseline: Named | None, proposed: Sequence[Named] | None
    ) -> tuple[Choice, tuple[Choice, ...]]:
        """The baseline, and the rewards that are compared with it; by default each other one of the environment's.

        The baseline is compared with itself, the null control, if it is named as the baseline and as a proposed reward,
        or as a proposed reward twice.

        Raises:
            UsageError: One is none of the environment's rewards.
        """
        names = [self._reward(it) for it in (self.rewards if proposed is None else proposed)]
        first = self._reward(baseline or self.baseline)
        times = names.count(first) + bool(baseline and proposed)
        return first, tuple(dict.fromkeys(name for name in names if name != first or times > 1))

    def _reward(self, given: Named) -> Choice:
        """One of the rewards, or one with the weights of its terms, ``gentle:effort=5``."""
        name, params = parse(given) if isinstance(given, str) else (str(given.get("name")), {**given})
        if name not in self.rewards and self.is_arm:
            return choose(self.registry, "rewards", given)
        if name not in self.rewards:
            own = self.registry.why_no_reward(name)
            raise UsageError(f"{self.label}: {own or unknown_name('reward', name, self.rewards)}")
        params.pop("name", None)
        terms = self._terms_of(name) if params else ()
        if params and not terms:
            raise UsageError(
                f"Reward '{name}' of '{self.label}' takes no parameters, since it pays no terms that could be weighed: "
                "give them to the environment"
            )
        changed = weights_of(name, params, terms)
        return Choice(name, tuple(changed.items()), label_of(name, changed))

    def require_direction(self, name: str) -> None:
        """Raise UsageError if nobody says what is better of a measure, and random actions show that it is no flag."""
        given = self.registry.functions_of("measure").get(name)
        where = (
            f"in '{given.file.path}'" if given else f"in the environment; gymnasium takes lower={name} or higher={name}"
        )
        how = f"write lower_is_better = ['{name}'] or higher_is_better = ['{name}'] {where}"
        with chdir("."), closing(self.environment.make()) as env:
            columns = columns_of(self.environment, env, self.registry)
            if direction_of(name, columns.lower_is_better, columns.higher_is_better, is_flag=name == SUCCESS):
                return
            (column,) = made_columns(env, {}, {name: columns.behaviour[name]}, 1, frozenset())
            for step in random_steps(env, 0, FIRST_STEPS, [column]):
                try:
                    (value,) = column.numbers(value_of(column, step))
                except (Exception, SystemExit):  # the trial tells what fails; an episode's end may tell a key of info
                    continue
                require_direction(name, "higher" if may_be_flag(value) else "", how)

    def _terms_of(self, name: str) -> tuple[str, ...]:
        """The terms that a reward pays for a step of random actions."""
        with chdir("."), closing(self.environment.make()) as env:
            given = columns_of(self.environment, env, self.registry).rewards[name]
            (column,) = made_columns(env, {name: given}, {}, 1, frozenset())
            for step in random_steps(env, 0, 1, [column]):
                try:
                    column.numbers(value_of(column, step))
                except (Exception, SystemExit) as error:  # whatever rewards of users raise
                    raise UsageError(f"Reward '{name}' fails in its first step: {reason_of(error)}") from error
            return column.terms or ()


def refuse_places(sim: Sequence[Named], robot: str | None) -> None:
    """Refuse options for what an environment brings itself.

    Raises:
        UsageError: Something is.
    """
    if sim or robot:
        flag = "--sim" if sim else "--robot"
        raise UsageError(
            f"{flag} does not go with an environment, which brings its own simulator and robot: leave it out"
        )


def look_at(task: Choice, registry: Registry) -> Looked:
    """Make an env, and look at its rewards, observations and actions.

    Raises:
        UsageError: The environment, or a library for it, cannot be used.
        PluginError: It raises; says whose it is.
    """
    environment: Environment = task.build(registry, "environments")
    with task.blamed(registry, "environments", PLANNED), closing(environment.make()) as env:
        columns = columns_of(environment, env, registry)
        names, measures = tuple(columns.rewards), tuple(columns.behaviour)
        for member in ("lower_is_better", "higher_is_better", "bounds"):
            for measure in set(getattr(columns, member)).difference(measures):
                raise UsageError(f"{task.label}: {member} names '{measure}', which is none of {sorted(measures)}")
        baseline = baseline_of(environment, dict.fromkeys(names, ""))
        if baseline not in names:
            raise UsageError(f"{task.label}: its baseline '{baseline}' is none of its rewards {', '.join(names)}")
        in_hindsight = frozenset(goal_rewards(environment, env))
        for name in in_hindsight.difference(names):
            raise UsageError(
                f"{task.label}: goal_rewards names '{name}', which is none of its rewards {', '.join(names)}"
            )
        unusable = _refusal(lambda: (flat_observations(env.observation_space), kind_of_actions(env.action_space)))
        return Looked(
            task.label,
            names,
            measures,
            baseline,
            None if unusable else kind_of_actions(env.action_space),
            unusable,
            in_hindsight,
            _refusal(lambda: goal_columns(env.observation_space)),
            bool(env.metadata.get(ARM)),
            environment,
            registry,
        )


def why_not_in(looked: Looked, algorithm: Choice, reward: str, registry: Registry, steps: int) -> str:
    """Why an algorithm cannot train in an environment by a reward for so many steps; empty if it can."""
    if looked.unusable:
        return looked.unusable
    with algorithm.blamed(registry, "algorithms", PLANNED):
        built: Algorithm = algorithm.build(registry, "algorithms")
        if needs_arm(built):
            return f"{algorithm.label} computes with the arm of a task, and {looked.label} is an environment"
        if looked.actions not in built.action_spaces:
            taken = " and ".join(sorted(built.action_spaces))
            return f"{algorithm.label} takes {taken} actions, those of {looked.label} are {looked.actions}"
        if steps % built.num_envs:
            return f"steps={steps} is not a multiple of the {built.num_envs} envs that {algorithm.label} trains on"
        if needs_goals(built) and (reason := looked.why_not_in_hindsight(reward)):
            return f"{algorithm.label} learns by paying steps again for other goals; in {looked.label} {reason}"
    return ""


def _refusal(ask: Callable[[], object]) -> str:
    try:
        ask()
    except UsageError as error:
        return str(error)
    return ""
