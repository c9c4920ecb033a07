"""Functions of which the code shows that they draw no random numbers and come to an end: nobody has to watch them.

And of which of them it shows that they say the same when they are asked later.
"""

import builtins
import cmath
import dis
import math
import operator
from collections.abc import Iterable, Iterator
from contextlib import suppress
from inspect import CO_VARARGS, CO_VARKEYWORDS
from types import BuiltinFunctionType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np

BUILTINS = {
    *("abs", "all", "any", "bool", "complex", "dict", "divmod", "enumerate", "filter", "float", "frozenset", "int"),
    *("isinstance", "iter", "len", "list", "map", "max", "min", "next", "pow", "print", "range", "reversed", "round"),
    *("set", "slice", "sorted", "str", "sum", "tuple", "zip", "ArithmeticError", "AttributeError", "Exception"),
    *("IndexError", "KeyError", "RuntimeError", "TypeError", "ValueError", "ZeroDivisionError"),
}
MODULES = (math, cmath, operator, np, np.linalg, np.fft)
NUMBERS = (int, float, complex, str, bytes, type(None), np.generic, np.ufunc)
GROWS = frozenset({"iter", "append", "extend", "insert", "add", "update", "setdefault"})
"""With these a loop over what there is may find ever more."""
IN_NUMPY = frozenset(dir(np))
"""Without names that NumPy only warns of, as ``str``."""
REACHES_FURTHER = frozenset({"IMPORT_NAME", "STORE_GLOBAL", "DELETE_GLOBAL", "LOAD_BUILD_CLASS"})


def only_computes(function: Any) -> bool:
    """Whether a function reaches nothing but numbers, mathematics, NumPy without its generators, and such functions.

    And whether these go back in their code only to take the next of what there is, as `for` does and `while` does not.

    Where that is not clear it is False.
    """
    return isinstance(function, FunctionType) and _is_harmless(function, set())


def may_wait(function: FunctionType) -> bool:
    """Whether a function that only computes says the same later: it reads no array of others, and prints nothing."""
    held = bound([function])
    codes = [code for it in held if isinstance(it, FunctionType) for code in _codes(it.__code__)]
    return not any(isinstance(it, np.ndarray) for it in held) and not any("print" in code.co_names for code in codes)


def bound(functions: Iterable[Any]) -> list[Any]:
    """Functions, and what they read by names of their own, and so on."""
    found, waiting, seen = list[Any](), [*functions], set[int]()
    while waiting:
        it = waiting.pop()
        found.append(it)
        if isinstance(it, tuple | frozenset):
            waiting += it
        elif isinstance(it, FunctionType) and id(it) not in seen and not (it.__module__ or "").startswith("numpy"):
            seen.add(id(it))
            waiting += used_by(it)
    return found


def used_by(function: Any) -> Iterator[Any]:
    """What a function was defined with, and what of its module it uses by a name; of a method, whose it is."""
    if isinstance(function, MethodType):
        yield function.__self__
    if not isinstance(function, FunctionType):
        return
    yield from function.__defaults__ or ()
    yield from (function.__kwdefaults__ or {}).values()
    for cell in function.__closure__ or ():
        with suppress(ValueError):  # it is empty
            yield cell.cell_contents
    names = dict.fromkeys(name for code in _codes(function.__code__) for name in code.co_names)
    yield from (function.__globals__[name] for name in names if name in function.__globals__)


def reads_last(function: Any) -> bool:
    """Whether a function that only computes looks at its last argument, unless it is known that it does not."""
    code = getattr(function, "__code__", None)
    if code is None or code.co_argcount != 4 or code.co_flags & (CO_VARARGS | CO_VARKEYWORDS):
        return True
    last = code.co_varnames[3]
    return last in code.co_cellvars or any(step.argval == last for step in dis.get_instructions(code))


def _is_harmless(found: Any, seen: set[int]) -> bool:
    """The same of anything that code uses by a name of its own."""
    if id(found) in seen or isinstance(found, NUMBERS):
        return True
    if isinstance(found, ModuleType | BuiltinFunctionType):
        return getattr(found, "__self__", found) in MODULES
    if isinstance(found, tuple | frozenset):
        return all(_is_harmless(part, seen) for part in found)
    if isinstance(found, np.ndarray):
        return not found.dtype.hasobject
    if not isinstance(found, FunctionType):
        return getattr(np, getattr(found, "__name__", ""), None) is found  # np.clip, np.float32
    seen.add(id(found))
    return all(_is_harmless(it, seen) for it in used_by(found)) and all(
        _is_plain(code, found.__globals__) for code in _codes(found.__code__)
    )


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for part in code.co_consts:
        if isinstance(part, CodeType):
            yield from _codes(part)


def _is_plain(code: CodeType, known: dict[str, Any]) -> bool:
    """Whether it imports nothing, and what it reads by name are globals that are `known`, `BUILTINS` and attributes."""
    steps = list(dis.get_instructions(code))
    targets = {step.argval for step in steps if "JUMP_BACKWARD" in step.opname}
    after = {step.offset: step.opname for step in steps}
    for step in reversed(steps):
        if step.opname == "EXTENDED_ARG":  # it begins a long argument of the next one
            after[step.offset] = after[step.offset + 2]
    back = {after[target] for target in targets}
    if not REACHES_FURTHER.isdisjoint(after.values()) or back - {"FOR_ITER"}:
        return False
    if back and not GROWS.isdisjoint(code.co_names):
        return False
    for name in code.co_names:
        inner = getattr(np, name) if name in IN_NUMPY else None
        is_builtin = hasattr(builtins, name) and name not in BUILTINS and inner is None
        if (name.startswith("_") or is_builtin) and name not in known:
            return False
        if isinstance(inner, ModuleType) and inner not in MODULES and name not in known:
            return False
    return True
