"""What a thing of each kind must have, and how it is called."""

import dataclasses
import inspect
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from harness.errors import PluginError
from harness.hookspecs import NOUNS
from harness.registry.spec import Spec

MEMBERS: Mapping[str, Mapping[str, int | None]] = MappingProxyType(
    {
        "simulators": {"open": 3},
        "algorithms": {"action_spaces": None, "num_envs": None, "train": 4},
        "rewards": {"initial_carry": 1, "__call__": 2},
        "metrics": {"unit": None, "better": None, "__call__": 1},
        "tasks": {
            **dict.fromkeys(
                ("robot", "epsilon", "ends_at_target", "horizon", "control_period", "decision_period", "ground_reward"),
            ),
            **dict.fromkeys(("step_reward", "action", "speed", "acceleration")),
            "target_rewards": 2,
            "motion": 1,
            "observation": 1,
            "check": 1,
            "draw_start": 2,
            "draw_targets": 3,
            "start_in_words": 1,
            "target_in_words": 1,
            "target_reward_in_words": 0,
        },
        "environments": {"make": 0, "rewards": 1, "behaviour": 1},
        "executors": {"run": 3},
        "trackers": {"why_not": 0, "begin": 1},
        "logs": {"recognises": 2, "read": 1, "write_example": 1},
        "descriptions": {"recognises": 2, "read": 3, "write_example": 1},
        "screens": {"screen": 2},
        "sections": {"what": None, "ending": 1, "show": 1},
    }
)
"""What a target of each kind must have: of a method how many arguments it is called with, of a value None."""


def require_members(spec: Spec, built: Any) -> None:
    """See that a built thing has every member that its kind asks for.

    Raises:
        PluginError: It lacks one; says whose plugin it is, and what a thing of its kind has.
    """
    missing = missing_members(spec.kind, built)
    if missing:
        raise PluginError(f"{spec.title} {missing}")


def missing_members(kind: str, thing: Any) -> str:
    """What a thing of one kind, or its class, lacks: ``has no train; an algorithm has ...``. Empty if it lacks nothing.

    A field of a dataclass counts as there.
    """
    members = MEMBERS.get(kind, {})
    fields = {field.name for field in dataclasses.fields(thing)} if dataclasses.is_dataclass(thing) else set()
    lacking = [name for name in members if name not in fields and not _has(thing, name)]
    if lacking:
        noun = f"{'an' if NOUNS[kind][0] in 'aeiou' else 'a'} {NOUNS[kind]}"
        return f"has no {', '.join(lacking)}; {noun} has {', '.join(members)}"
    for name, count in members.items():
        if count is not None and not _takes(getattr(thing, name), count + inspect.isclass(thing)):
            arguments = f"{count} argument{'s' * (count != 1)}"
            return f"cannot be called as it has to be: {name} takes {arguments} beside self"
    return ""


def sample_of(target: Any) -> Any:
    """One with default parameters, which may have members that the class has not; the class itself if that fails."""
    try:
        return target()
    except (Exception, SystemExit):
        return target


def _has(thing: Any, name: str) -> bool:
    """Whether a class or an object of it has a member; every class can be called, which says nothing of its objects."""
    if name == "__call__":
        kind = thing if inspect.isclass(thing) else type(thing)
        return any(name in vars(base) for base in kind.__mro__)
    return hasattr(thing, name)


def _takes(method: Any, count: int) -> bool:
    """Whether it can be called with so many arguments by position."""
    try:
        inspect.signature(method).bind(*[None] * count)
    except TypeError:
        return False
    except ValueError:  # compiled, without a signature
        return True
    return True
