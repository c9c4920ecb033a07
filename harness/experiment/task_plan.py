"""One task of an experiment, looked at before anything runs: where it is trained, by which rewards, and what fits."""

import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol, TypeAlias

from harness.algorithm import IN_ENVIRONMENTS, ActionSpace, Algorithm, needs_goals, why_not
from harness.errors import UsageError, sentence
from harness.eta.laws import require_direction
from harness.log.measure import Measure
from harness.record.cell import BROUGHT, EVALUATION_HORIZON
from harness.registry.choice import Choice, Registry, choose, kind_of_task, require_known, split_list
from harness.registry.measure_functions import EPISODE, HIGHER, LOWER, SUCCESS
from harness.registry.spec import PLANNED, unknown_name
from harness.results.metrics import fields_needed, load_metrics, require_measures
from harness.reward.forms import STEP
from harness.reward.given import ARGUMENTS
from harness.reward.steps import BEFORE, NOT_RECORDED
from harness.reward.terms import needs_of

if TYPE_CHECKING:
    from harness.robot import Robot
    from harness.task import Task

Given: TypeAlias = str | dict[str, Any]
DEFAULT_BASELINE, DEFAULT_REWARDS = "baseline", ("arp", "dense")
"""Where an experiment names none; an environment has rewards of its own, and is compared in all of them."""
NO_GOALS = (
    "learns by paying steps again for other goals. A task of an arm does not allow that: its rewards depend on earlier "
    "steps, touching the ground is paid too, and its observations contain the offset to the target. "
    "Give an environment with goals, such as --task fetch-reach"
)
UNMEASURED = (
    "No measure says what the agent does, so the report cannot say whether it behaves better. Give a file of "
    "functions, --measure behaviour.py, or name keys of info, --task gymnasium:id=...,tells=KEY"
)
OWN_HORIZON = (
    "--evaluation-horizon goes with an environment. A task of an arm has a horizon of its own, "
    "such as --task fd100-reach:horizon=50"
)


class Asked(Protocol):
    """What an experiment says that decides how its tasks are trained; see `harness.experiment.plan.Experiment`."""

    @property
    def sim(self) -> list[Given]:
        """Simulators."""

    @property
    def robot(self) -> str | None:
        """The robot; None for the task's own."""

    @property
    def baseline(self) -> Given | None:
        """The reward that others are compared with; None for the default."""

    @property
    def reward(self) -> list[Given] | None:
        """Proposed rewards; None for the default."""

    @property
    def steps(self) -> int:
        """Environment steps of each training."""

    @property
    def measure(self) -> list[str]:
        """Measures that come first; the first one decides."""

    @property
    def evaluation_horizon(self) -> int | None:
        """In an environment: steps after which an episode of an evaluation is cut."""


class Fit(NamedTuple):
    """How an algorithm can do a plan."""

    task: Choice
    """The task in the form that the algorithm takes; as given if there is no such form."""
    reason: str
    """Why the algorithm cannot do the plan; empty if it can."""


@dataclass(frozen=True)
class TaskPlan:
    """One task, or an environment, and what trains in it.

    Attributes:
        task: The task.
        simulators: Where; that of `harness.record.cell.BROUGHT` alone if the task is an environment.
        robot: Name or folder of the arm, or what stands for it there.
        baseline: The reward that the others are compared with.
        rewards: All others, in their order. The baseline is among them if it is compared with itself.
        fit: How an algorithm can train in it by a reward.
        horizon: In an environment: steps after which an episode of an evaluation is cut.
        tell_reward: How an experiment file holds a reward.
        brought: Keys of an experiment file that the task leaves without a meaning, because it brings these things.
        require_metrics: Raises UsageError unless there are metrics, or measures of the environment, of these names.
        needs: What an experiment file says of the plugins that were given by hand.
        defaults: The class variable in which an algorithm may declare other defaults for such tasks; empty if none.
        warnings: What to know before anything is trained, a line each.
        records: What traces keep beside the usual columns, because a reward or a measure reads it.
        measure: Names of measures as the experiment file keeps them, the one that decides first; empty for the default.
    """

    task: Choice
    simulators: tuple[Choice, ...]
    robot: str
    baseline: Choice
    rewards: tuple[Choice, ...]
    fit: Callable[[Choice, Choice], Fit]
    tell_reward: Callable[[Choice], Any]
    brought: tuple[str, ...]
    require_metrics: Callable[[Sequence[str]], None]
    needs: Sequence[Mapping[str, Any]]
    defaults: str = ""
    horizon: int = EVALUATION_HORIZON
    warnings: tuple[str, ...] = ()
    records: tuple[str, ...] = ()
    measure: tuple[str, ...] = ()

    @property
    def has_control(self) -> bool:
        """Whether the baseline is compared with itself."""
        return self.baseline in self.rewards

    @property
    def trained(self) -> tuple[Choice, ...]:
        """All rewards, the baseline first."""
        return tuple(dict.fromkeys([self.baseline, *self.rewards]))


def plan_tasks(asked: Asked, tasks: Sequence[Given], registry: Registry) -> list[TaskPlan]:
    """Look at every task of an experiment.

    Raises:
        UsageError: Something cannot be used, tasks are mixed with environments, or the baselines differ.
        PluginError: A plugin is broken, or raises; says whose it is.
    """
    each = {str(it): it for it in tasks}.values()  # a name given again is one task
    kinds = {kind_of_task(task, registry) for task in each}
    if len(kinds) > 1:
        named = ", ".join(map(str, each))
        raise UsageError(f"task={named}: some are tasks of an arm, some environments. Make an experiment of each kind")
    if kinds == {"environments"}:
        found = [_in_environment(asked, task, registry) for task in each]
    else:
        from harness.robot.robot import load_robot  # here, as all of arms and of environments: a run needs one kind

        load = cache(partial(load_robot, registry=registry))  # tasks mostly have one robot
        found = [_with_arm(asked, task, registry, load) for task in each]
    baselines = {it.baseline.label: it.task.label for it in found}
    if len(baselines) > 1:
        told = ", ".join(f"{name} ({task})" for name, task in baselines.items())
        raise UsageError(f"The tasks have different baselines: {told}. Name one that all of them have: --baseline NAME")
    return found


def unnamed(key: str, noun: str) -> str:
    """The message that an experiment lacks a name."""
    return f"{sentence(noun)} names no {key}: give --{key} NAME, or the key '{key}' in a file"


def choose_each(registry: Registry, kind: str, given: Sequence[Given]) -> tuple[Choice, ...]:
    """What names say, each once."""
    return tuple(dict.fromkeys(choose(registry, kind, item) for item in given))


def _with_arm(asked: Asked, given: Given, registry: Registry, load: "Callable[[str], Robot]") -> TaskPlan:
    """A task of an arm."""
    from harness.simulator import require_drives
    from harness.task import choose_task

    if asked.evaluation_horizon is not None:
        raise UsageError(OWN_HORIZON)
    if not asked.sim:
        require_known(given, registry)
        raise UsageError(unnamed("sim", "experiment"))
    simulators = choose_each(registry, "simulators", asked.sim)
    baseline = choose(registry, "rewards", asked.baseline or DEFAULT_BASELINE)
    rewards = choose_each(registry, "rewards", [*DEFAULT_REWARDS] if asked.reward is None else asked.reward)
    require_known(given, registry)
    robot = _locate(asked.robot or choose(registry, "tasks", given).build(registry, "tasks").robot, registry)
    task, arm = choose_task(registry, given, robot, load)
    built = task.build(registry, "tasks")
    with task.blamed(registry, "tasks", PLANNED):
        built.check(arm)
    for simulator in simulators:
        require_drives(simulator.build(registry, "simulators"), arm)
    fits: dict[Choice, Fit] = {}

    def fit(algorithm: Choice, reward: Choice) -> Fit:
        if algorithm not in fits:
            fits[algorithm] = _fit(algorithm, task, arm, registry, asked.steps)
        return fits[algorithm]

    def require(names: Sequence[str]) -> None:
        load_metrics(registry, names)

    brought = ("evaluation_horizon",)
    measure, untaken = _measures_of_arm(asked, registry)
    warnings = (*(f"robot {arm.name}: {line}" for line in arm.warnings), *untaken)
    reads = {field for choice in (baseline, *rewards) for field in _needs(choice, built, arm, registry)}
    reads |= fields_needed(registry)
    records = tuple(name for name in NOT_RECORDED if reads & {name, f"{BEFORE}.{name}"})
    return TaskPlan(
        task, simulators, robot, baseline, rewards, fit, table_of, brought, require,
        registry.needs(in_environment=False), warnings=warnings, records=records, measure=measure,
    )  # fmt: skip


def _measures_of_arm(asked: Asked, registry: Registry) -> tuple[tuple[str, ...], list[str]]:
    """The measures that an arm's experiment names; the one called ``success`` decides, if a file has it.

    Returns:
        Their names, and a line for each function that measures nothing here.

    Raises:
        UsageError: There is no measure of a name.
    """
    functions, known = registry.functions_of("measure"), registry.names("metrics")
    untaken = {
        name: f"{it.file.name}: the measure '{name}' takes {ARGUMENTS}, as in environments, and measures no arm. "
        f"Write {name}({STEP}), or {name}({EPISODE}) of a whole episode"
        for name, it in functions.items()
        if it.spec is None
    }
    for name in asked.measure:
        if name not in known:
            raise UsageError(untaken.get(name) or unknown_name("measure", name, known))
    for name in asked.measure[:1]:
        measure: Measure = Choice(name).build(registry, "metrics")
        where = f"'{functions[name].file.path}'" if name in functions else "its class as `better`"
        how = f"write {LOWER} = ['{name}'] or {HIGHER} = ['{name}'] into {where}"
        require_direction(name, measure.better, how)
    given = [SUCCESS] if SUCCESS in functions and functions[SUCCESS].spec else []
    return tuple(asked.measure or given), list(untaken.values())


def _needs(choice: Choice, task: "Task", arm: "Robot", registry: Registry) -> tuple[str, ...]:
    """What a reward reads of a step of the arm; nothing of one that fails, which the trial before a run tells."""
    try:
        return needs_of(choice.build(registry, "rewards"), arm.dof, task.motion(arm).action_size).fields
    except UsageError:
        return ()


def _fit(algorithm: Choice, task: Choice, robot: "Robot", registry: Registry, steps: int) -> Fit:
    with algorithm.blamed(registry, "algorithms", PLANNED):
        try:
            form = task_for(algorithm, task, robot, registry)
        except UsageError as error:
            return Fit(task, str(error))
        built: Algorithm = algorithm.build(registry, "algorithms")
        if steps % built.num_envs:
            envs = f"the {built.num_envs} envs that {algorithm.label} trains on"
            return Fit(form, f"steps={steps} is not a multiple of {envs}")
        if needs_goals(built):
            return Fit(form, f"{algorithm.label} {NO_GOALS}")
        return Fit(form, why_not(built, form.build(registry, "tasks"), robot))


def _in_environment(asked: Asked, given: Given, registry: Registry) -> TaskPlan:
    """An environment; simulator and robot are its own."""
    from harness.experiment.environments.plan import look_at, refuse_places, why_not_in

    refuse_places(asked.sim, asked.robot)
    task = choose(registry, "environments", given)
    looked = look_at(task, registry)
    for name in asked.measure:
        if name not in looked.measures:
            told = f"{looked.label}: {unknown_name('measure', name, looked.measures)}"
            key = f"A key of info becomes a measure by --task gymnasium:id=...,tells={name}"
            path = f"'{name}' needs the whole path, which an arm's own run records: --task fd100-reach --sim NAME"
            raise UsageError(f"{told} {path if name in registry.names('metrics') else key}")
    for name in (*asked.measure, *looked.measures)[:1]:
        looked.require_direction(name)
    baseline, rewards = looked.rewards_asked(asked.baseline, asked.reward)

    def fit(algorithm: Choice, reward: Choice) -> Fit:
        return Fit(task, why_not_in(looked, algorithm, reward.label, registry, asked.steps))

    def require(names: Sequence[str]) -> None:
        require_measures(split_list(names), looked.measures)

    return TaskPlan(
        task,
        (BROUGHT.simulator,),
        BROUGHT.robot,
        baseline,
        rewards,
        fit,
        tell_reward=lambda reward: table_of(reward) if reward.params else reward.name,
        brought=("sim", "robot"),
        require_metrics=require,
        needs=registry.needs(in_environment=True),
        defaults=IN_ENVIRONMENTS,
        horizon=asked.evaluation_horizon or EVALUATION_HORIZON,
        warnings=() if looked.measures else (UNMEASURED,),
        records=tuple(dict.fromkeys(it.label for it in (baseline, *rewards) if it.name not in looked.rewards)),
        measure=tuple(asked.measure),
    )


def _locate(robot: str, registry: Registry) -> str:
    """A registered name as it is, a path in full: a cell means the same from any working directory."""
    path = Path(robot)
    if robot in registry.names("robots") or not os.path.exists(path):  # no error, whatever the text
        return robot
    # A link to a URDF stays one: what lies beside it is looked for where the user says that it is.
    return str(path.resolve() if path.is_dir() else path.parent.resolve() / path.name)


def table_of(choice: Choice) -> dict[str, Any]:
    """A choice as an experiment file holds it; a parameter that is None is left out, for TOML has no word for it."""
    params = {key: value for key, value in choice.to_json()["params"].items() if value is not None}
    return {"name": choice.name, **params}


def task_for(algorithm: Choice, task: Choice, robot: "Robot", registry: Registry) -> Choice:
    """The task as it is if the algorithm takes its actions; else, for choices among continuous ones, in discrete form.

    The discrete form is another task, with a label of its own: ``action=discrete:action=MODE``, whose choices are
    staying and one increment of one joint or axis of the mode.

    Raises:
        UsageError: The task has no form that the algorithm takes.
    """
    built: Algorithm = algorithm.build(registry, "algorithms")
    space = _space_of(task, robot, registry)
    if space in built.action_spaces:
        return task
    taken = " and ".join(sorted(built.action_spaces))
    problem = f"{algorithm.label} takes {taken} actions, the task's are {space}"
    if "discrete" not in built.action_spaces:
        raise UsageError(problem)
    return _discrete(task, problem, robot, registry)


def _discrete(task: Choice, problem: str, robot: "Robot", registry: Registry) -> Choice:
    params = task.named
    if not isinstance(params.get("action"), str):
        raise UsageError(f"{problem}, and it has no parameter 'action' to choose others")
    try:
        # Text, so that what the mode's own parameters are is found out as for any user.
        form = choose(registry, "tasks", {"name": task.name, **params, "action": f"discrete:action={params['action']}"})
        if _space_of(form, robot, registry) == "discrete":
            return form
    except UsageError as error:
        raise UsageError(f"{problem}, and it has no discrete form: {error}") from error
    raise UsageError(f"{problem}, with action={form.named['action']} too")


def _space_of(task: Choice, robot: "Robot", registry: Registry) -> ActionSpace:
    from harness.motion.discrete import Discrete

    built = task.build(registry, "tasks")
    with task.blamed(registry, "tasks", PLANNED):
        built.check(robot)
        return "discrete" if isinstance(built.motion(robot), Discrete) else "continuous"
