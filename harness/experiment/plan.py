"""What to do: an experiment as a user writes it, and the cells it expands to."""

import hashlib
import itertools
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Annotated, Any, NamedTuple, TypeAlias

from pydantic import Field
from pydantic.dataclasses import dataclass as checked_dataclass

from harness.algorithm import Algorithm, needs_goals, why_not
from harness.errors import UsageError, sentence
from harness.experiment.environments.plan import kind_of_task, look_at, refuse_places, require_known, why_not_in
from harness.experiment.task_form import task_for
from harness.record.cell import EVALUATION_HORIZON as HORIZON
from harness.record.cell import NO_ROBOT, NO_SIMULATOR, Cell
from harness.record.plan_file import control_seeds
from harness.registry.choice import Choice, choose, split_list
from harness.registry.names import unknown_name
from harness.registry.parameters import build
from harness.registry.registry import Registry
from harness.registry.spec import PLANNED, blamed_on
from harness.registry.toml_file import read_toml
from harness.robot import Robot
from harness.robot.load import load_robot
from harness.simulator import require_drives

Given: TypeAlias = str | dict[str, Any]

MOST_NAMES = 1_000
"""The most names in a list of simulators, algorithms or rewards."""
MOST_SEEDS = 10_000
"""The most seeds. With more, intervals hardly get narrower, and the trainings in sequence would take a year."""
LARGEST_SEED = 2**31 - 1
"""The largest seed. Every generator takes it, also when the null control adds as much again."""
MOST_STEPS = 1_000_000_000
"""The most steps of a training: eleven days at 1,000 steps a second."""
MOST_EPISODES = 100_000
"""The most episodes of an evaluation. A share of successes is then exact to 0.2 %."""
MOST_CELLS = 100_000
"""The most cells of a plan. All are in memory, and each leaves a folder."""

Names: TypeAlias = Annotated[list[Given], Field(min_length=1, max_length=MOST_NAMES)]
SeedCount: TypeAlias = Annotated[int, Field(gt=0, le=MOST_SEEDS)]
Steps: TypeAlias = Annotated[int, Field(gt=0, le=MOST_STEPS)]
Episodes: TypeAlias = Annotated[int, Field(gt=0, le=MOST_EPISODES)]
Seed: TypeAlias = Annotated[int, Field(ge=0, le=LARGEST_SEED)]
Interval: TypeAlias = Annotated[int, Field(ge=0, le=MOST_STEPS)]
LISTS = ("sim", "algo", "reward", "measure")


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
DEFAULT_TASK, DEFAULT_BASELINE, DEFAULT_REWARDS = "fd100-reach", "baseline", ("arp",)
"""Where an experiment names none; an environment has rewards of its own, and is compared in all of them."""


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
    baseline: Annotated[Given | None, Field(description="reward that the proposed rewards are compared with")] = None
    task: Annotated[Given, Field(description="task, or an environment in its place")] = DEFAULT_TASK
    robot: Annotated[
        str | None, Field(description="robot: a name, a URDF file, or a folder with robot.toml; None: the task's own")
    ] = None
    seeds: Annotated[
        SeedCount | Annotated[list[Seed], Field(min_length=1, max_length=MOST_SEEDS)],
        Field(description="number of seeds, counted from 0, or a list of seeds"),
    ] = 6
    steps: Annotated[Steps, Field(description="environment steps of training per cell")] = 5_000
    evaluation_episodes: Annotated[Episodes, Field(description="episodes per evaluation")] = 100
    evaluate_every: Annotated[
        Interval, Field(description="environment steps from one evaluation to the next; 0: evaluate only at the end")
    ] = 0
    deterministic: Annotated[bool, Field(description="whether policies are evaluated without randomness")] = True
    measure: Annotated[
        list[str],
        Field(max_length=MOST_NAMES, description="measures of an environment that come first; the first one decides"),
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
        measures: If the task is an environment: what it measures, by name; the first one decides.
    """

    baseline: str
    cells: tuple[Cell, ...]
    skipped: tuple[tuple[Cell, str], ...]
    resolved: dict[str, Any]
    control: Mapping[int, int] = field(default_factory=dict)
    warnings: tuple[str, ...] = ()
    measures: tuple[str, ...] = ()

    @property
    def is_in_environment(self) -> bool:
        """Whether the task is an environment."""
        return any(cell.is_in_environment for cell in self.cells)

    @property
    def id(self) -> str:
        """A hash of the cells."""
        return hashlib.sha256("".join(cell.id for cell in self.cells).encode()).hexdigest()[:8]


def read_experiment(path: Path, overrides: Mapping[str, Any]) -> Experiment:
    """The experiment in a TOML file; an override wins over a key.

    Raises:
        UsageError: The file cannot be read, or holds what no experiment has.
    """
    return check_experiment(read_toml(path, "experiment file", overrides), f"experiment file '{path}'")


def check_experiment(data: Mapping[str, Any], noun: str = "experiment") -> Experiment:
    """An experiment from its keys.

    Raises:
        UsageError: A key is unknown or missing, or a value is of the wrong type or out of range.
    """
    for key in ("sim", "algo") if data.get("task", DEFAULT_TASK) == DEFAULT_TASK else ("algo",):
        if not data.get(key):
            raise UsageError(_unnamed(key, noun))
    listed = {key: _split_names(value) if key in LISTS else value for key, value in data.items()}
    experiment: Experiment = build(Experiment, listed, noun)
    return experiment


def _unnamed(key: str, noun: str) -> str:
    return f"{sentence(noun)} names no {key}: give --{key} NAME, or the key '{key}' in a file"


def expand(experiment: Experiment, registry: Registry) -> Plan:
    """All cells of an experiment: simulator x algorithm x reward x seed; in an environment algorithm x reward x seed.

    An algorithm that takes discrete actions only gets a task with continuous ones in its discrete form.

    Raises:
        UsageError: A name or parameter is unknown, a library is missing, the robot cannot do the task or has no drives
            for ``drive=servo``, or there are more cells than `MOST_CELLS`.
        PluginError: A plugin is broken, or raises; says whose it is.
    """
    if kind_of_task(experiment.task, registry) == "environments":
        return _expand_in_environment(experiment, registry)
    if experiment.measure:
        raise UsageError("--measure goes with an environment: an arm is judged by success and time to the target")
    if experiment.evaluation_horizon is not None:
        raise UsageError(OWN_HORIZON)
    if not experiment.sim:
        require_known(experiment.task, registry)
        raise UsageError(_unnamed("sim", "experiment"))
    simulators = _choose_each(registry, "simulators", experiment.sim)
    algorithms = _choose_each(registry, "algorithms", experiment.algo)
    baseline = choose(registry, "rewards", experiment.baseline or DEFAULT_BASELINE)
    proposed: list[Given] = [*DEFAULT_REWARDS] if experiment.reward is None else experiment.reward
    rewards = _choose_each(registry, "rewards", proposed)
    require_known(experiment.task, registry)
    task = choose(registry, "tasks", experiment.task)
    built = task.build(registry, "tasks")
    robot = _locate(experiment.robot or built.robot, registry)
    arm = load_robot(robot, registry)
    with blamed_on(registry.get("tasks", task.name), PLANNED):
        built.check(arm)
    for simulator in simulators:
        require_drives(simulator.build(registry, "simulators"), arm)
    seeds = experiment.seed_list
    control = control_seeds(seeds) if baseline in rewards else {}
    paid = dict.fromkeys([baseline, *rewards])
    _require_few(len(seeds), len(simulators), len(algorithms), len(paid))
    # Seeds outermost: every reward has a run early, and a plan that is cut short still compares.
    matrix = [
        *itertools.product(seeds, simulators, algorithms, paid),
        *itertools.product(control.values(), simulators, algorithms, [baseline]),
    ]
    forms = {algorithm: _fit(algorithm, task, arm, registry, experiment.steps) for algorithm in algorithms}
    cells = [
        Cell(
            simulator, robot, forms[algorithm].task, algorithm, reward, seed, experiment.steps,
            experiment.evaluation_episodes, experiment.evaluate_every, experiment.deterministic,
        )
        for seed, simulator, algorithm, reward in matrix
    ]  # fmt: skip
    reasons = {algorithm: form.reason for algorithm, form in forms.items()}
    return Plan(
        baseline.label,
        tuple(cell for cell in cells if not reasons[cell.algorithm]),
        tuple((cell, reasons[cell.algorithm]) for cell in cells if reasons[cell.algorithm]),
        _resolve(experiment, simulators, algorithms, baseline, rewards, task, robot, registry.needs()),
        control=control,
        warnings=tuple(registry.broken_files()),
    )


def _expand_in_environment(experiment: Experiment, registry: Registry) -> Plan:
    """The cells of an experiment whose task is an environment; simulator and robot are the environment's own."""
    refuse_places(experiment.sim, experiment.robot, experiment.evaluate_every)
    task = choose(registry, "environments", experiment.task)
    algorithms = _choose_each(registry, "algorithms", experiment.algo)
    looked = look_at(task, registry)
    for name in experiment.measure:
        if name not in looked.measures:
            told = f"{looked.label}: {unknown_name('measure', name, looked.measures)}"
            raise UsageError(f"{told} A key of info becomes a measure by --task gymnasium:id=...,tells={name}")
    baseline, rewards = looked.rewards_asked(experiment.baseline, experiment.reward)
    seeds, horizon = experiment.seed_list, experiment.evaluation_horizon or HORIZON
    _require_few(len(seeds), 1, len(algorithms), len(rewards))
    reasons = {
        (algorithm, reward): why_not_in(looked, algorithm, reward, registry, experiment.steps)
        for algorithm, reward in itertools.product(algorithms, rewards)
    }
    cells = [
        Cell(
            NO_SIMULATOR, NO_ROBOT, task, algorithm, Choice(reward, (), reward), seed, experiment.steps,
            experiment.evaluation_episodes, deterministic=experiment.deterministic, evaluation_horizon=horizon,
        )
        for seed, algorithm, reward in itertools.product(seeds, algorithms, rewards)
    ]  # fmt: skip
    given = _given(experiment, registry.needs())
    why_not_of = [(cell, reasons[cell.algorithm, cell.reward.name]) for cell in cells]
    return Plan(
        baseline,
        tuple(cell for cell, reason in why_not_of if not reason),
        tuple((cell, reason) for cell, reason in why_not_of if reason),
        {
            **{key: value for key, value in given.items() if key not in ("sim", "robot")},
            "algo": [table_of(choice) for choice in algorithms],
            "reward": [reward for reward in rewards if reward != baseline],
            "baseline": baseline,
            "task": table_of(task),
            "evaluation_horizon": horizon,
        },
        warnings=(*registry.broken_files(), *([] if looked.measures else [UNMEASURED])),
        measures=looked.measures,
    )


def _require_few(seeds: int, simulators: int, algorithms: int, rewards: int) -> None:
    """Raise UsageError if the matrix is too large, before it is made."""
    count = seeds * simulators * algorithms * rewards
    if count > MOST_CELLS:
        factors = f"{seeds} seeds x {simulators} simulators x {algorithms} algorithms x {rewards} rewards"
        raise UsageError(f"{factors} are {count:,} cells, {MOST_CELLS:,} are allowed. Make several experiments of it.")


def _split_names(given: Any) -> Any:
    """Names one by one: ``"a,b:x=1"`` and ``["a", "b:x=1"]`` are the same; tables stand as they are."""
    if not isinstance(given, list):
        given = [given]
    parts = [split_list(item) if isinstance(item, str) else [item] for item in given]
    return [name for part in parts for name in part]


def _locate(robot: str, registry: Registry) -> str:
    """A registered name as it is, a path in full: a cell means the same from any working directory."""
    path = Path(robot)
    if robot in registry.names("robots") or not os.path.exists(path):  # no error, whatever the text
        return robot
    # A link to a URDF stays one: what lies beside it is looked for where the user says that it is.
    return str(path.resolve() if path.is_dir() else path.parent.resolve() / path.name)


def _choose_each(registry: Registry, kind: str, given: list[Given]) -> list[Choice]:
    return list(dict.fromkeys(choose(registry, kind, item) for item in given))


class Fit(NamedTuple):
    """How an algorithm can do a plan."""

    task: Choice
    """The task in the form that the algorithm takes; as given if there is no such form."""
    reason: str
    """Why the algorithm cannot do the plan; empty if it can."""


def _fit(algorithm: Choice, task: Choice, robot: Robot, registry: Registry, steps: int) -> Fit:
    with blamed_on(registry.get("algorithms", algorithm.name), PLANNED):
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


def _resolve(
    experiment: Experiment,
    simulators: list[Choice],
    algorithms: list[Choice],
    baseline: Choice,
    rewards: list[Choice],
    task: Choice,
    robot: str,
    needs: Sequence[Mapping[str, Any]],
) -> dict[str, Any]:
    """The keys of an experiment file, defaults and all."""
    return {
        **{key: value for key, value in _given(experiment, needs).items() if key != "evaluation_horizon"},
        "sim": [table_of(choice) for choice in simulators],
        "algo": [table_of(choice) for choice in algorithms],
        "reward": [table_of(choice) for choice in rewards],
        "baseline": table_of(baseline),
        "task": table_of(task),
        "robot": robot,
    }


def _given(experiment: Experiment, needs: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """The keys of an experiment file as they were given, but for the list of seeds, and of plugins."""
    values = {field.name: getattr(experiment, field.name) for field in fields(experiment) if field.name != "plugins"}
    if not experiment.measure:
        del values["measure"]
    plugins = {"plugins": needs} if needs else {}
    return {**values, **plugins, "seeds": experiment.seed_list}


def table_of(choice: Choice) -> dict[str, Any]:
    """As an experiment file holds it; a parameter that is None is left out, for TOML has no word for it."""
    params = {key: value for key, value in choice.to_json()["params"].items() if value is not None}
    return {"name": choice.name, **params}
