"""Copies of a reward that has a memory: one for each env, which measures the env that is stepped and no other."""

import copy
import functools
from collections.abc import Iterator, Mapping
from enum import Enum
from logging import Logger
from types import CellType, FunctionType, MethodType, ModuleType
from typing import Any

import gymnasium
import numpy as np
from gymnasium.envs.registration import EnvSpec
from gymnasium.vector import VectorEnv

from harness.errors import UsageError
from harness.recorder.computing import used_by

MOST_PARTS = 100_000
"""Objects that are looked at in an env or a reward; an env that holds a data set may have millions."""
WITHOUT_STATE = (
    str, bytes, int, float, complex, type(None), type, Enum, ModuleType, np.dtype, Logger, gymnasium.Space, EnvSpec
)  # fmt: skip
"""Kinds of objects that say nothing of the state of an env, so that a copy is as good."""
WHAT_TO_DO = (
    "Read what it needs from the observations or from info, or give a function, which is not copied and may use the env"
)


def own_copies(given: Any, noun: str, env: Any, count: int) -> tuple[list[Any], bool]:
    """Copies of an object with ``reset()``, one for each env.

    A copy that holds an env would look at a copy of that env, which nobody steps. With one env the copy therefore keeps
    the env itself, and every part of it that the object holds. With several envs nobody can say whose env is meant.

    Args:
        given: The object.
        noun: What messages call it.
        env: What is recorded, a single env or a batch.
        count: How many copies.

    Returns:
        The copies, and whether they hold the env or a part of it.

    Raises:
        UsageError: It cannot be copied. Or it holds an env: another one than the one that is recorded, or one of a
            batch.
    """
    held, parts = _parts_of(given), _parts_of(env, but=given)
    envs = [part for part in held.values() if isinstance(part, gymnasium.Env | VectorEnv)]
    shared = {key: part for key, part in held.items() if key in parts}
    if any(id(part) not in parts for part in envs):
        raise UsageError(
            f"{noun} holds an env that is not the one that is recorded, so it would measure an env that nobody steps. "
            f"{WHAT_TO_DO}"
        )
    if shared and count > 1:
        raise UsageError(
            f"{noun} has reset(), so each of the {count} envs needs a copy of it, but it holds "
            f"{_told(next(iter(shared.values())))} of the envs. A copy would look at a copy of that, which nobody "
            f"steps. {WHAT_TO_DO}"
        )
    try:
        return [copy.deepcopy(given, dict(shared)) for _ in range(count)], bool(shared)
    except Exception as error:  # whatever objects of users raise
        raise UsageError(
            f"{noun} has a memory, and each env needs a copy of its own, but it cannot be copied: {error!r}"
        ) from error


def as_defined(function: Any) -> Any:
    """A function of the same code whose memory stands where this one's stands now; None where it cannot be made.

    Defaults, closures, attributes, and what of its module it uses by a name are copied, as far as they are containers
    or objects with attributes. Functions, classes and modules that it uses are shared.
    """
    if not isinstance(function, FunctionType):
        return None
    names = {name for name in function.__code__.co_names if name in function.__globals__}
    try:
        known = {name: _copied(function.__globals__[name]) for name in names}
        cells = tuple(CellType(_copied(cell.cell_contents)) for cell in function.__closure__ or ())
        defaults = tuple(map(_copied, function.__defaults__ or ()))
        copied = FunctionType(function.__code__, {**function.__globals__, **known}, function.__name__, defaults, cells)
        copied.__kwdefaults__ = {name: _copied(value) for name, value in (function.__kwdefaults__ or {}).items()}
        vars(copied).update({name: _copied(value) for name, value in vars(function).items()})
    except Exception:  # an empty cell, or whatever objects of users raise
        return None
    copied.__globals__.update({name: copied for name in names if function.__globals__[name] is function})
    return copied


def _copied(value: Any) -> Any:
    return value if callable(value) or isinstance(value, WITHOUT_STATE) else copy.deepcopy(value)


def uses_parts_of(given: Any, env: Any) -> bool:
    """Whether a function can reach an env: by what it was defined with, or by names of its module that it uses."""
    return not _parts_of(given, of_functions=True).keys().isdisjoint(_parts_of(env, but=given))


def _parts_of(whole: Any, but: Any = None, of_functions: bool = False) -> Mapping[int, Any]:
    """The object, and every object with a state that it holds at any depth, by identity; what only `but` holds not.

    What functions use counts only with `of_functions`: they are not copied.
    """
    found: dict[int, Any] = {}
    waiting = [whole]
    while waiting and len(found) < MOST_PARTS:
        part = waiting.pop()
        is_empty = isinstance(part, tuple | frozenset) and not part  # of these Python has one for all
        if id(part) not in found and part is not but and not isinstance(part, WITHOUT_STATE) and not is_empty:
            found[id(part)] = part
            waiting += used_by(part) if of_functions and isinstance(part, FunctionType) else _held_by(part)
    return found


def _held_by(part: Any) -> Iterator[Any]:
    if isinstance(part, dict):
        yield from part.values()
    elif isinstance(part, list | tuple | set | frozenset):
        yield from part
    elif isinstance(part, MethodType):
        yield part.__self__
    elif isinstance(part, functools.partial):
        yield from (part.func, *part.args, *part.keywords.values())
    elif not callable(part) or not hasattr(part, "__code__"):  # a function is not copied, whatever it uses
        yield from getattr(part, "__dict__", {}).values()


def _told(part: Any) -> str:
    """A held part in words."""
    if isinstance(part, gymnasium.Env | VectorEnv):
        return "one"
    return "an array" if isinstance(part, np.ndarray) else f"a part ({type(part).__qualname__})"
