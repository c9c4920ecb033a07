"""What a reward is given: steps with named fields.

Steps are a named tuple of arrays, whose first axis counts them: one step of each env of a batch, or the rows of a log.
Which fields there are depends on where the steps come from. One that is not there is refused by its name.
"""

import difflib
from collections import namedtuple
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, lru_cache
from itertools import islice
from types import MappingProxyType
from typing import Any, NamedTuple, TypeAlias

import numpy as np

from harness.errors import UsageError

Steps: TypeAlias = Any
"""Steps, with the fields of `ARM` or some of them; of an environment those of `ENVIRONMENT`."""
DISTANCE = "distance"
ENDS = ("terminated", "truncated")
"""Fields that say whether an episode ended with the step."""
BEFORE = "before"
"""The field whose fields tell what there was before the steps."""


class MissingField(UsageError, AttributeError):
    """Steps do not have a field that a reward reads.

    Attributes:
        field: Its name.
    """

    def __init__(self, field: str, there: Iterable[str], where: str = "A step", told: str = "") -> None:
        """Say what there is.

        Args:
            field: What was asked for, ``joint_speed`` or ``before.joint_speed``.
            there: Names of the fields that there are.
            where: What the steps are of, to begin the message with.
            told: A last sentence.
        """
        self.field, names = field, tuple(there)
        guess = nearest(field.rpartition(".")[2], names)
        super().__init__(
            f"{where} has no '{field}'. It has: {', '.join(names)}.{guess.lstrip('.')}{told and f' {told}'}"
        )


@lru_cache(256)
def nearest(name: str, there: tuple[str, ...]) -> str:
    """The nearest of the names that there are, as the end of a sentence; empty if none is near.

    Kept, since a reward may ask in every step whether a field is there.
    """
    near = difflib.get_close_matches(SYNONYMS.get(name, name), there, n=1)
    return f". Did you mean '{near[0]}'?" if near else ""


SYNONYMS: Mapping[str, str] = MappingProxyType(
    {
        **dict.fromkeys(("joint_position", "joint_positions", "joint_angles", "angles", "joints", "position"), "qpos"),
        **dict.fromkeys(("joint_speed", "joint_speeds", "joint_velocity", "joint_velocities", "velocity"), "qvel"),
        **dict.fromkeys(("dof_vel", "speed", "speeds"), "qvel"),
        **dict.fromkeys(("dof_pos",), "qpos"),
        **dict.fromkeys(("actions", "torque", "effort", "act"), "action"),
        **dict.fromkeys(("tip", "ee", "ee_pos", "tcp", "gripper"), "end_effector"),
        **dict.fromkeys(("goal", "goal_position", "target_position"), "target"),
        **dict.fromkeys(("collision", "contact", "ground_contact"), "ground"),
        **dict.fromkeys(("obs", "state", "next_observation", "next_obs"), "observation"),
    }
)
"""What others call a field."""


def _missing(steps: Any, name: str) -> Any:
    if name.startswith("_"):  # what Python itself asks for, as in copying
        raise AttributeError(name)
    raise MissingField(name, steps._fields)


class Sample(NamedTuple):
    """The distances of a step of an arm, which every step of an arm begins with. Arrays of shape (num_envs,)."""

    begin_distance: Any
    """Bd = d(0), NOTE eq. 22, [m]."""
    previous_best: Any
    """Pb, the smallest distance of the episode before this step; Pb(0) = Bd, NOTE eq. 17, [m]."""
    previous_distance: Any
    """d(t-1), [m]; where a new target was set, its begin distance."""
    distance: Any
    """d(t), end effector to target after the step, NOTE eq. 14, [m]."""
    delta_distance: Any
    """d(t) - Pb, NOTE eq. 15, [m]."""
    step: Any
    """t, counted from 1 in each episode."""

    def __getattr__(self, name: str) -> Any:
        return _missing(self, name)


def _told(steps: Any) -> dict[str, Any]:
    return dict(zip(steps._fields, tuple.__iter__(steps), strict=True))


@cache
def steps_type(fields: tuple[str, ...]) -> type[Any]:
    """The type of steps with these fields: a named tuple that refuses every other one by name.

    Who unpacks a step of an arm gets the distances of `Sample`, which were all that a reward once knew.
    """
    members: dict[str, Any] = {"__slots__": (), "__getattr__": _missing, "_asdict": _told}
    members["_replace"] = lambda steps, **given: type(steps)._make({**_told(steps), **given}.values())
    members["__reduce__"] = lambda steps: (steps_of, (_told(steps),))  # nobody finds the type by its name
    if fields[: len(Sample._fields)] == Sample._fields:
        members["__iter__"] = lambda steps: islice(tuple.__iter__(steps), len(Sample._fields))
    return type("Steps", (namedtuple("Steps", fields),), members)


def steps_of(fields: Mapping[str, Any]) -> Steps:
    """Steps with these fields, in their order."""
    return steps_type(tuple(fields))._make(fields.values())


def step_between(
    state: Mapping[str, Any], after: Mapping[str, Any], begin: Any, best: Any, step: Any, previous: Any = None
) -> Steps:
    """The step from one state to another, of n episodes.

    Args:
        state: The fields before the step, (n, ...) each; ``distance`` is among them. How an earlier step ended is none.
        after: The same after it; its action is that of the step. What it lacks, the step lacks.
        begin: Begin distances, (n,), [m].
        best: The smallest distances until the state, (n,), [m].
        step: Numbers of the step, counted from 1, (n,).
        previous: Distances to its target before the step, (n,), [m]; None where it is that of the state.
    """
    distance, previous = after[DISTANCE], state[DISTANCE] if previous is None else previous
    six = Sample(begin, best, previous, distance, distance - best, step)
    before = {name: it for name, it in state.items() if name not in ENDS}
    return steps_of({**six._asdict(), **after, BEFORE: steps_of(before)})


def map_steps(function: Callable[[Any], Any], steps: Steps) -> Steps:
    """Steps with what a function makes of each of their arrays, and of those of what was before them."""
    told = steps._asdict().values()
    return type(steps)._make(map_steps(function, part) if isinstance(part, tuple) else function(part) for part in told)


def rows_of(steps: Steps, rows: Any) -> Steps:
    """Some rows of steps, and of what was before them."""
    return map_steps(lambda array: array[rows], steps)


def joined(parts: Sequence[Steps]) -> Steps:
    """The rows of several steps one after the other, and what was before them."""
    columns = zip(*(part._asdict().values() for part in parts), strict=True)
    return type(parts[0])._make(joined(it) if isinstance(it[0], tuple) else np.concatenate(it) for it in columns)


@dataclass(frozen=True)
class Field:
    """A field of steps, for people.

    Attributes:
        name: Its name.
        shape: Of the array, ``num_envs`` first.
        unit: Of its numbers; empty if they have none.
        told: What it is, in a line.
        before: Whether ``before`` has it too.
    """

    name: str
    shape: str
    unit: str
    told: str
    before: bool = False


ARM = (
    Field("begin_distance", "(num_envs,)", "m", "distance to the target at the episode's start, Bd"),
    Field("previous_best", "(num_envs,)", "m", "smallest distance of the episode before this step, Pb; Bd at first"),
    Field("previous_distance", "(num_envs,)", "m", "distance before this step, d(t-1); Bd where a new target was set"),
    Field("distance", "(num_envs,)", "m", "distance after this step, d(t)", before=True),
    Field("delta_distance", "(num_envs,)", "m", "d(t) - Pb"),
    Field("step", "(num_envs,)", "steps", "t, counted from 1 in each episode"),
    Field("qpos", "(num_envs, dof)", "rad", "joint positions after the step", before=True),
    Field("qvel", "(num_envs, dof)", "rad/s", "joint speeds after the step", before=True),
    Field("action", "(num_envs, action_size)", "", "what the policy asked for; before the first step 0", before=True),
    Field("end_effector", "(num_envs, 3)", "m", "where the end effector is, world frame", before=True),
    Field("target", "(num_envs, 3)", "m", "where the target of the step is, world frame", before=True),
    Field("ground", "(num_envs,)", "bool", "whether the step touched the ground", before=True),
    Field("terminated", "(num_envs,)", "bool", "whether the ground, an obstacle or the target ended the episode"),
    Field("truncated", "(num_envs,)", "bool", "whether the time limit cut the episode after the step"),
)
"""What steps of an arm have."""
ENVIRONMENT = (
    Field("observation", "as the environment's", "", "what the env observed after the step", before=True),
    Field("action", "as the environment's", "", "what the policy did; before the first step zeros", before=True),
    Field("info", "a dict", "", "what the env told of the step; before the first step of the reset", before=True),
    Field("terminated", "a bool", "", "whether the env ended the episode with the step"),
    Field("truncated", "a bool", "", "whether a time limit cut the episode after the step"),
)
"""What a step of an environment has: one step of one env, without a first axis."""
ARM_BEFORE = tuple(field.name for field in ARM if field.before)
NOT_RECORDED = ("qvel",)
"""Fields that a trace has only where a reward of the experiment reads them."""
