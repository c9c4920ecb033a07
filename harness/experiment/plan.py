"""What to do: an experiment as a user writes it, and the cells it expands to."""

import hashlib
import itertools
import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BeforeValidator, Field
from pydantic.dataclasses import dataclass as checked_dataclass

from harness.errors import UsageError
from harness.eta.verdict.halving import schedule_of
from harness.eta.verdict.looks import MARGIN
from harness.experiment.looks import own_seed, terms_of
from harness.experiment.task_plan import Given, TaskPlan, plan_tasks, table_of, unnamed
from harness.record.cell import EVALUATION_HORIZON as HORIZON, Cell
from harness.record.file_forms import MOST_CELLS, MOST_SEEDS
from harness.record.plan_file import control_seeds
from harness.record.terms import NEW, Terms
from harness.registry.choice import Choice, Registry, choose, split_list
from harness.registry.members import build
from harness.registry.toml_file import read_toml

MOST_NAMES = 1_000
"""The most names in a list of simulators, algorithms or rewards."""
LARGEST_SEED = 2**31 - 1
"""The largest seed. Every generator takes it, also when the null control adds as much again."""
MOST_LOOKS = 100
"""The most looks at results."""
MOST_STEPS = 1_000_000_000
"""The most steps of a training: eleven days at 1,000 steps a second."""
MOST_EPISODES = 100_000
"""The most episodes of an evaluation. A share of successes is then exact to 0.2 %."""

Names: TypeAlias = Annotated[list[Given], Field(min_length=1, max_length=MOST_NAMES)]


def _no_bool(given: Any) -> Any:
    """What is given, unless it is true or false, which pydantic takes for 1 and 0."""
    if isinstance(given, bool):
        raise ValueError("must be a number, not true or false")
    return given


Number: TypeAlias = Annotated[int, BeforeValidator(_no_bool)]
SeedCount: TypeAlias = Annotated[Number, Field(gt=0, le=MOST_SEEDS)]
Steps: TypeAlias = Annotated[Number, Field(gt=0, le=MOST_STEPS)]
EpisodeCount: TypeAlias = Annotated[Number, Field(gt=0, le=MOST_EPISODES)]
Seed: TypeAlias = Annotated[Number, Field(ge=0, le=LARGEST_SEED)]
Interval: TypeAlias = Annotated[Number, Field(ge=0, le=MOST_STEPS)]
NO_BASELINE = "none"
"""In place of a baseline: one reward is trained alone."""
LISTS = ("sim", "algo", "reward", "measure")


DEFAULT_TASK = "fd100-reach"
"""Where an experiment names none."""


@checked_dataclass(frozen=True, kw_only=True)
class Experiment:
    """A matrix of combinations; each field is a key of an experiment file and a flag of ``harness run``.

    Names stand as text (``"arp:k2=2"``) or, in a file, as a table (``{name = "arp", k2 = 2}``).
    """

    sim: Annotated[
        list[Given],
        Field(max_length=MOST_NAMES, description="simulators to train in; none if the task is an environment"),
    ] = Field(default_factory=list)
    algo: Annotated[Names, Field(description="algorithms to train with")]
    reward: Annotated[
        Annotated[list[Given], Field(max_length=MOST_NAMES)] | None,
        Field(description="proposed rewards; an empty list: only the baseline is trained"),
    ] = None
    baseline: Annotated[
        Given | None, Field(description="reward that the proposed rewards are compared with; none: one reward alone")
    ] = None
    task: Annotated[
        Given | Annotated[list[Given], Field(min_length=1, max_length=MOST_NAMES)],
        Field(description="task, or an environment in its place; or a list of tasks, or of environments"),
    ] = DEFAULT_TASK
    robot: Annotated[
        str | None, Field(description="robot: a name, a URDF file, or a folder with robot.toml; None: the task's own")
    ] = None
    seeds: Annotated[
        SeedCount | Annotated[list[Seed], Field(min_length=1, max_length=MOST_SEEDS)],
        Field(description="number of seeds, counted from 0, or a list of seeds"),
    ] = 6
    until: Annotated[
        Literal["", "decided", "best"],
        Field(description="decided: train in looks until there is an answer; best: see which reward goes furthest"),
    ] = ""
    looks: Annotated[
        list[SeedCount] | None,
        Field(max_length=MOST_LOOKS, description="with until: seeds at each look, increasing; None: the usual ones"),
    ] = None
    margin: Annotated[
        float, Field(gt=0.0, lt=1.0, description="with until: a difference of success below this ends the training")
    ] = MARGIN
    trainings: Annotated[
        SeedCount | None, Field(description="with until best: how many trainings it may take; None: the usual number")
    ] = None
    minutes: Annotated[
        float | None, Field(gt=0.0, lt=1e7, description="with until best, instead of trainings: how long it may take")
    ] = None
    steps: Annotated[Steps, Field(description="environment steps of training per cell")] = 10_000
    evaluation_episodes: Annotated[EpisodeCount, Field(description="episodes per evaluation")] = 100
    evaluate_every: Annotated[
        Interval, Field(description="environment steps from one evaluation to the next; 0: evaluate only at the end")
    ] = 0
    deterministic: Annotated[bool, Field(description="whether policies are evaluated without randomness")] = True
    measure: Annotated[
        list[str],
        Field(max_length=MOST_NAMES, description="measures that come first; the first one decides"),
    ] = Field(default_factory=list)
    evaluation_horizon: Annotated[
        Steps | None,
        Field(
            description=f"in an environment: steps after which an episode of an evaluation is cut; None: {HORIZON:,}"
        ),
    ] = None
    plugins: Annotated[
        list[Given], Field(max_length=MOST_NAMES, description="required plugins, which you have to give with --plugin")
    ] = Field(default_factory=list)

    @property
    def tasks(self) -> list[Given]:
        """The tasks, in their order."""
        return self.task if isinstance(self.task, list) else [self.task]

    @property
    def seed_list(self) -> list[int]:
        """The seeds, each once."""
        return list(range(self.seeds)) if isinstance(self.seeds, int) else list(dict.fromkeys(self.seeds))


@dataclass(frozen=True)
class Plan:
    """A resolved experiment: what it compares, and the cells that it needs.

    Attributes:
        baseline: Label of the reward that the others are compared with.
        cells: What to run, in this order.
        skipped: Combinations that cannot work, each with the reason.
        resolved: The experiment with every default filled in, as an experiment file holds it.
        control: Where the baseline is compared with itself, the null control: by each seed the other seed that it is
            trained with again.
        warnings: What to know before anything is trained, a line each.
        terms: What is agreed on before the first training.
        require_metrics: Raises UsageError unless there are metrics, or measures of the environments, of these names.
    """

    baseline: str
    cells: tuple[Cell, ...]
    skipped: tuple[tuple[Cell, str], ...]
    resolved: dict[str, Any]
    control: Mapping[int, int] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    terms: Terms = NEW
    require_metrics: Callable[[Sequence[str]], None] = field(default=lambda names: None, compare=False)

    @property
    def id(self) -> str:
        """A hash of the cells."""
        return hashlib.sha256("".join(cell.id for cell in self.cells).encode()).hexdigest()[:8]


def read_experiment(path: Path, overrides: Mapping[str, Any]) -> Experiment:
    """The experiment in a TOML file; an override wins over a key.

    Raises:
        UsageError: The file cannot be read, or holds what no experiment has.
    """
    data = read_toml(path, "experiment file", overrides)
    if overrides.get("until") and "seeds" not in overrides:
        data.pop("seeds", None)  # those of an experiment that was trained at once
    return check_experiment(data, f"experiment file '{path}'")


def check_experiment(data: Mapping[str, Any], noun: str = "experiment") -> Experiment:
    """An experiment from its keys.

    Raises:
        UsageError: A key is unknown or missing, or a value is of the wrong type or out of range.
    """
    for key in ("sim", "algo") if data.get("task", DEFAULT_TASK) == DEFAULT_TASK else ("algo",):
        if not data.get(key):
            raise UsageError(unnamed(key, noun))
    if data.get("until") and data.get("seeds") is not None:
        raise UsageError(f"until={data['until']} finds the number of seeds itself: leave out seeds, or give looks")
    if not data.get("until") and data.get("looks") is not None:
        raise UsageError("looks go with until: give --until decided")
    given = [key for key in ("trainings", "minutes") if data.get(key) is not None]
    if given and (data.get("until") != "best" or len(given) > 1):
        raise UsageError(f"{' and '.join(given)}: give one of trainings and minutes, with until best")
    listed = {key: _split_names(value) if key in LISTS else value for key, value in data.items()}
    if "task" in data:
        tasks = _split_names(data["task"])
        listed["task"] = tasks[0] if len(tasks) == 1 else tasks
    experiment: Experiment = build(Experiment, listed, noun)
    return experiment


Begun: TypeAlias = Callable[[Plan], Collection[Choice]]
"""A function that tells which algorithms a plan's folder holds already; none if the folder is not there yet."""


def expand(experiment: Experiment, registry: Registry, begun: Begun = lambda plan: ()) -> Plan:
    """All cells of an experiment: task x simulator x algorithm x reward x seed; an environment has no simulator.

    An algorithm that takes discrete actions only gets a task with continuous ones in its discrete form. In an
    environment an algorithm has the defaults that it declares for environments. Version 0.2 did not know these: a
    folder that was begun without them goes on without them.

    Args:
        experiment: What a user wrote.
        registry: The plugins.
        begun: Tells what the folder holds that the plan goes into.

    Raises:
        UsageError: A name or parameter is unknown, a library is missing, the robot cannot do the task or has no drives
            for ``drive=servo``, or there are more cells than `MOST_CELLS`.
        PluginError: A plugin is broken, or raises; says whose it is.
    """
    _require_few_names(experiment)
    experiment = _alone(experiment, registry)
    tasks = plan_tasks(experiment, experiment.tasks, registry)
    plain = [choose(registry, "algorithms", it) for it in experiment.algo]
    fitted = [choose(registry, "algorithms", it, tasks[0].defaults) for it in experiment.algo]
    plan = _plan(experiment, tasks, fitted, registry)
    if fitted == plain:
        return plan
    there = begun(plan) or begun(_plan(experiment, tasks, plain, registry))
    kept = [old if old in there and new not in there else new for old, new in zip(plain, fitted, strict=True)]
    if kept == fitted:
        return plan
    told = [_goes_on(old, new) for old, new in zip(kept, fitted, strict=True) if old != new]
    plan = _plan(experiment, tasks, kept, registry)
    return replace(plan, warnings=(*plan.warnings, *dict.fromkeys(told)))


def _goes_on(old: Choice, new: Choice) -> str:
    """The line that an algorithm keeps the defaults with which a folder was begun."""
    then = old.named
    values = [f"{key}={then.get(key, 'default')}" for key, value in new.params if then.get(key) != value]
    return f"the folder was begun with {old.name}:{','.join(values)} and goes on so; in a new folder it is {new.label}"


def _plan(experiment: Experiment, tasks: Sequence[TaskPlan], chosen: Iterable[Choice], registry: Registry) -> Plan:
    """The cells of tasks that were looked at, with each of the chosen algorithms once."""
    algorithms = tuple(dict.fromkeys(chosen))
    terms = terms_of(experiment, tasks, algorithms) if experiment.until else NEW
    places = sum(len(it.simulators) for it in tasks) * len(algorithms)
    schedule = schedule_of(terms.asked, terms.budget, places) if terms.budget else None
    last = schedule.seeds + schedule.fresh if schedule else terms.looks[-1] if terms.looks else 0
    seeds = list(range(last)) if terms.has_plan else experiment.seed_list
    _require_few(len(seeds), tasks, len(algorithms))
    fits = {(it.task, *pair): it.fit(*pair) for it in tasks for pair in itertools.product(algorithms, it.trained)}
    control = control_seeds(seeds) if any(it.has_control for it in tasks) else {}
    # Seeds outermost: every reward has a run early, and a plan that is cut short still compares.
    matrix = [
        *((seed, it, *rest) for seed in seeds for it in tasks for rest in _product(it, algorithms, it.trained)),
        *(
            (seed, it, *rest)
            for seed in control.values()
            for it in tasks
            if it.has_control
            for rest in _product(it, algorithms, [it.baseline])
        ),
    ]
    planned = [
        (_cell(experiment, it, simulator, fit.task, algorithm, reward, seed), fit.reason)
        for seed, it, simulator, algorithm, reward in matrix
        for fit in [fits[it.task, algorithm, reward]]
    ]
    if schedule:  # the baseline is no candidate: it trains with the new seeds alone
        planned = [it for it in planned if it[0].reward != tasks[0].baseline or it[0].seed >= schedule.seeds]
    if terms.has_plan:
        planned = [(own_seed(cell), reason) for cell, reason in planned]
    return Plan(
        tasks[0].baseline.label,
        tuple(cell for cell, reason in planned if not reason),
        tuple((cell, reason) for cell, reason in planned if reason),
        _resolve(experiment, tasks, algorithms, tasks[0].needs),
        control=control,
        terms=terms,
        warnings=(*registry.broken_files(), *dict.fromkeys(line for it in tasks for line in it.warnings)),
        require_metrics=tasks[0].require_metrics if len(tasks) == 1 else _require_any(tasks),
    )


def _alone(experiment: Experiment, registry: Registry) -> Experiment:
    """An experiment whose baseline is `NO_BASELINE`: its one reward takes the place of the baseline, and is alone."""
    if experiment.baseline != NO_BASELINE or NO_BASELINE in registry.names("rewards"):
        return experiment
    rewards = experiment.reward or []
    if len(rewards) != 1:
        raise UsageError(
            f"baseline={NO_BASELINE} trains one reward alone, and {len(rewards)} are named: give one, --reward NAME, "
            "or the baseline that they are compared with"
        )
    return replace(experiment, baseline=rewards[0], reward=[])


def _product(
    task: TaskPlan, algorithms: Sequence[Choice], rewards: Sequence[Choice]
) -> "itertools.product[tuple[Choice, Choice, Choice]]":
    return itertools.product(task.simulators, algorithms, rewards)


def _cell(
    experiment: Experiment, it: TaskPlan, simulator: Choice, form: Choice, algorithm: Choice, reward: Choice, seed: int
) -> Cell:
    return Cell(
        simulator, it.robot, form, algorithm, reward, seed, experiment.steps, experiment.evaluation_episodes,
        experiment.evaluate_every, experiment.deterministic, it.horizon, it.records,
    )  # fmt: skip


def _require_few_names(experiment: Experiment) -> None:
    """Raise UsageError if the names alone are too many, before one of them is looked up."""
    lists: dict[str, Sequence[Any]] = {
        "tasks": experiment.tasks,
        "simulators": experiment.sim,
        "algorithms": experiment.algo,
        "rewards": experiment.reward or [],
        "seeds": [] if experiment.until else experiment.seed_list,
    }
    counts = {noun: len({str(name) for name in names}) for noun, names in lists.items() if names}
    if math.prod(counts.values()) > MOST_CELLS:
        factors = " x ".join(f"{count} {noun}" for noun, count in counts.items())
        raise UsageError(
            f"{factors} are {math.prod(counts.values()):,} cells, {MOST_CELLS:,} are allowed. "
            "Make several experiments of it."
        )


def _require_few(seeds: int, tasks: Sequence[TaskPlan], algorithms: int) -> None:
    """Raise UsageError if the matrix is too large, before it is made."""
    count = seeds * algorithms * sum(len(it.simulators) * (len(it.trained) + it.has_control) for it in tasks)
    if count > MOST_CELLS:
        first = tasks[0]
        factors = f"{seeds} seeds x {len(first.simulators)} simulators x {algorithms} algorithms"
        factors = f"{factors} x {len(first.trained)} rewards" + (f" x {len(tasks)} tasks" if len(tasks) > 1 else "")
        factors += ", with a null control," if first.has_control else ""
        raise UsageError(f"{factors} are {count:,} cells, {MOST_CELLS:,} are allowed. Make several experiments of it.")


def _split_names(given: Any) -> Any:
    """Names one by one: ``"a,b:x=1"`` and ``["a", "b:x=1"]`` are the same; tables stand as they are."""
    if not isinstance(given, list):
        given = [given]
    parts = [split_list(item) if isinstance(item, str) else [item] for item in given]
    return [name for part in parts for name in part]


def _resolve(
    experiment: Experiment,
    tasks: Sequence[TaskPlan],
    algorithms: Sequence[Choice],
    needs: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:
    """The keys of an experiment file, defaults and all."""
    first, robots = tasks[0], {it.robot for it in tasks}
    rewards = dict.fromkeys(reward for it in tasks for reward in it.rewards)
    named = [table_of(it.task) for it in tasks]
    told = {
        "sim": [table_of(choice) for choice in first.simulators],
        "algo": [table_of(choice) for choice in algorithms],
        "reward": [first.tell_reward(choice) for choice in rewards],
        "baseline": first.tell_reward(first.baseline),
        "task": named[0] if len(named) == 1 else named,
        "robot": first.robot if len(robots) == 1 else None,
        "evaluation_horizon": first.horizon,
        "measure": list(first.measure),
    }
    left_out = (*first.brought, *(["measure"] if not first.measure else []))
    return {key: value for key, value in {**_given(experiment, needs), **told}.items() if key not in left_out}


def _given(experiment: Experiment, needs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The keys of an experiment file as they were given, but for the list of seeds, and of plugins."""
    values = {field.name: getattr(experiment, field.name) for field in fields(experiment) if field.name != "plugins"}
    plugins = {"plugins": needs} if needs else {}
    if experiment.until:
        del values["seeds"]
        return {**values, **plugins}
    for key in ("until", "looks", "margin", "trainings", "minutes"):
        del values[key]
    return {**values, **plugins, "seeds": experiment.seed_list}


def _require_any(tasks: Sequence[TaskPlan]) -> Callable[[Sequence[str]], None]:
    """A check that passes if one of several tasks has the metrics: another one may lack them."""

    def require(names: Sequence[str]) -> None:
        problems = []
        for task in tasks:
            try:
                task.require_metrics(names)
            except UsageError as error:
                problems.append(error)
        if len(problems) == len(tasks):
            raise problems[0]

    return require
