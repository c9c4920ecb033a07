"""A search as a user writes it, and the resolved search."""

import hashlib
import json
import tomllib
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Annotated, Any, Literal, TypeAlias

import tomli_w
from pydantic import Field
from pydantic.dataclasses import dataclass as checked_dataclass

from harness.authoring.commands import (
    DEFAULT_TASK,
    Choice,
    EpisodeCount,
    Names,
    Plan,
    Registry,
    Seed,
    SeedCount,
    Steps,
    build,
    check_experiment,
    expand,
    read_toml,
    table_of,
)
from harness.errors import UsageError, sentence

from .space import Dimension, parse_space, why_no_range

FIRST_SEED = 1_000_000
"""The first seed of a search's trainings. It is far from 0, 1, ..., with which ``harness run`` trains."""

NOUN = "search"
MOST_TRIALS = 10_000
"""The most trials of a search, because the sampler looks at all earlier ones."""

Given: TypeAlias = str | dict[str, Any]
"""A name with parameters, as text or as a table."""
Trials: TypeAlias = Annotated[int, Field(gt=0, le=MOST_TRIALS)]


@checked_dataclass(frozen=True)
class Tuning:
    """A search; each field is a key of a tuning file and a flag of ``harness tune``."""

    algo: Annotated[
        Names,
        Field(description="algorithm, with the parameters that stay fixed and the values at which the search begins"),
    ]
    sim: Annotated[list[Given], Field(description="simulator to train in; none if the task is an environment")] = Field(
        default_factory=list
    )
    reward: Annotated[Names | None, Field(description="proposed rewards")] = None
    baseline: Annotated[Given | None, Field(description="reward that the proposed rewards are compared with")] = None
    task: Annotated[Given, Field(description="task to train on, or an environment")] = DEFAULT_TASK
    measure: Annotated[
        list[str], Field(description="measures of an environment that come first; the first one judges")
    ] = Field(default_factory=list)
    robot: Annotated[str | None, Field(description="robot; None: the task's own")] = None
    search: Annotated[
        dict[str, str | list[Any]],
        Field(description="values to search, by parameter: LOW..HIGH, LOW..HIGH:log, A|B|C or a list"),
    ] = Field(default_factory=dict)
    trials: Annotated[Trials, Field(description="number of settings that each search tries")] = 20
    seeds: Annotated[SeedCount, Field(description="number of trainings of each setting with each reward")] = 2
    steps: Annotated[Steps, Field(description="environment steps of each training")] = 10_000
    validation_episodes: Annotated[
        EpisodeCount, Field(description="episodes of the validation that scores each policy")
    ] = 100
    per_reward: Annotated[
        bool, Field(description="whether each reward has a search of its own, instead of one for all rewards")
    ] = False
    pruner: Annotated[
        Literal["median", "none"],
        Field(description="median: a trial below the median of the finished ones ends early; none: no trial does"),
    ] = "median"
    batch: Annotated[Trials, Field(description="trials drawn together, so that they can run at once")] = 1
    seed: Annotated[Seed, Field(description="seed for drawing settings from the ranges")] = 0


@dataclass(frozen=True)
class Setup:
    """A resolved search.

    Attributes:
        tuning: What was asked for.
        base: The algorithm as it was given: where the search begins, and all that is not searched.
        space: What is searched.
        rewards: The baseline, then the proposed ones.
        experiment: Keys of the experiment that the search is for, defaults and all.
        keys: Everything that decides which trials there are and what they are worth, as a tuning file holds it.
    """

    tuning: Tuning
    base: Choice
    space: tuple[Dimension, ...]
    rewards: tuple[Choice, ...]
    experiment: dict[str, Any]
    keys: dict[str, Any]

    @property
    def id(self) -> str:
        """A hash of what decides the trials."""
        return hashlib.sha256(json.dumps(self.keys, sort_keys=True).encode()).hexdigest()[:8]

    @property
    def seeds(self) -> list[int]:
        """Seeds of the trainings."""
        return [FIRST_SEED + index for index in range(self.tuning.seeds)]

    @property
    def searches(self) -> list[tuple[Choice, ...]]:
        """The rewards of each search."""
        return [(reward,) for reward in self.rewards] if self.tuning.per_reward else [self.rewards]

    def plan(self, algorithms: Sequence[Choice], rewards: Sequence[Choice], registry: Registry, **keys: Any) -> Plan:
        """The cells of these algorithms and rewards; `keys` are those of an experiment to say otherwise."""
        data = {
            **self.experiment,
            "algo": [table_of(algorithm) for algorithm in algorithms],
            "reward": [table_of(reward) for reward in rewards[1:]],
            "baseline": table_of(rewards[0]),
            **keys,
        }
        return expand(check_experiment(data, NOUN), registry)


def read_tuning(path: Path, overrides: Mapping[str, Any]) -> Tuning:
    """The search in a TOML file; an override wins over a key.

    Raises:
        UsageError: The file cannot be read, or holds what no search has.
    """
    return check_tuning(read_toml(path, "tuning file", overrides), f"tuning file '{path}'")


def check_tuning(data: Mapping[str, Any], noun: str = NOUN) -> Tuning:
    """A search from its keys.

    Raises:
        UsageError: A key is unknown or missing, or a value is of the wrong type or out of range.
    """
    has_arm = data.get("task", DEFAULT_TASK) == DEFAULT_TASK or data.get("sim") == ""
    needed = ("sim", "algo") if has_arm else ("algo",)
    missing = [key for key in needed if not data.get(key)]
    if missing:
        flags, keys = (" and ".join(form.format(key) for key in missing) for form in ("--{} NAME", "'{}'"))
        in_file = f"the key{'s' * (len(missing) > 1)} {keys} in a file"
        raise UsageError(f"{sentence(noun)} names no {' and no '.join(missing)}: give {flags}, or {in_file}")
    _require_table(data.get("search", {}), noun)
    listed = {key: [value] if _is_single(key, value) else value for key, value in data.items()}
    tuning: Tuning = build(Tuning, listed, noun)
    return tuning


def _require_table(search: Any, noun: str) -> None:
    """Raise UsageError if the key ``search`` of a file is no table of texts and lists."""
    if not isinstance(search, Mapping):
        raise UsageError(f"{sentence(noun)}: search={search!r}: write a table [search] with a line for each parameter")
    for name, given in search.items():
        if not isinstance(given, str | list):
            raise UsageError(f"{sentence(noun)}: {why_no_range(name, given)}")


def resolve(
    tuning: Tuning, registry: Registry, begun: Callable[[Setup], Collection[Choice]] = lambda setup: ()
) -> Setup:
    """Everything that the search needs, checked.

    Args:
        tuning: What a user wrote.
        registry: The plugins.
        begun: A function that tells with which algorithm the folder of a search was begun; nothing of a new folder.

    Raises:
        UsageError: A name or parameter is unknown, a library is missing, or the algorithm cannot do the task.
    """
    names = ("sim", "algo", "reward", "baseline", "task", "robot", "steps", "measure")
    given = {key: value for key in names if (value := getattr(tuning, key)) is not None}
    experiment = check_experiment(given, NOUN)
    plan = expand(experiment, registry, lambda plan: begun(_setup(tuning, plan, registry)))
    return _setup(tuning, plan, registry)


def _setup(tuning: Tuning, plan: Plan, registry: Registry) -> Setup:
    for _, reason in plan.skipped:
        raise UsageError(f"Nothing to search: {reason}")
    for key, noun, found in (
        ("sim", "simulator", {cell.simulator for cell in plan.cells}),
        ("algo", "algorithm", {cell.algorithm for cell in plan.cells}),
    ):
        if len(found) > 1:
            raise UsageError(f"--{key} names {len(found)}: a search is of one {noun}")
    base = plan.cells[0].algorithm
    target = registry.get("algorithms", base.name).load()
    space = parse_space(tuning.search, target, f"algorithm '{base.name}'")
    experiment = {key: value for key, value in plan.resolved.items() if key not in ("seeds", "evaluation_episodes")}
    rewards = tuple(dict.fromkeys(cell.reward for cell in plan.cells))
    return Setup(tuning, base, space, rewards, experiment, _keys(tuning, plan.resolved, space))


def _is_single(key: str, value: Any) -> bool:
    return key in ("sim", "algo", "reward") and not isinstance(value, list)


def _keys(tuning: Tuning, resolved: Mapping[str, Any], space: Sequence[Dimension]) -> dict[str, Any]:
    """The keys as they are read back from TOML, so that they can be compared with those in a folder."""
    values = {field.name: getattr(tuning, field.name) for field in fields(tuning) if field.name != "trials"}
    names = ("sim", "algo", "reward", "baseline", "task", "robot")
    search = {dimension.name: dimension.text for dimension in space}
    keys = {**values, **{name: resolved.get(name) for name in names}, "search": search}
    told = {key: value for key, value in keys.items() if value not in (None, [])}
    return tomllib.loads(tomli_w.dumps(told))
