"""Functions of which the code shows that they draw no random numbers and come to an end: nobody has to watch them."""

import builtins
import cmath
import dis
import math
import operator
from collections.abc import Iterator
from types import BuiltinFunctionType, CodeType, FunctionType, ModuleType
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
IN_NUMPY = frozenset(dir(np))
"""Without names that NumPy only warns of, as ``str``."""
REACHES_FURTHER = frozenset({"IMPORT_NAME", "STORE_GLOBAL", "DELETE_GLOBAL", "LOAD_BUILD_CLASS"})


def only_computes(function: Any) -> bool:
    """Whether a function reaches nothing but numbers, mathematics, NumPy without its generators, and such functions.

    And whether none of these goes back in its code, as loops do.

    Where that is not clear it is False.
    """
    return isinstance(function, FunctionType) and _is_harmless(function, set())


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
    held = (*(found.__defaults__ or ()), *(found.__kwdefaults__ or {}).values())
    cells = [cell.cell_contents for cell in found.__closure__ or () if _is_full(cell)]
    return all(_is_harmless(it, seen) for it in (*held, *cells, *_globals_of(found))) and all(
        _is_plain(code, found.__globals__) for code in _codes(found.__code__)
    )


def _is_full(cell: Any) -> bool:
    try:
        return cell.cell_contents is not None
    except ValueError:
        return False


def _globals_of(function: FunctionType) -> Iterator[Any]:
    names = {name for code in _codes(function.__code__) for name in code.co_names}
    yield from (function.__globals__[name] for name in names if name in function.__globals__)


def _codes(code: CodeType) -> Iterator[CodeType]:
    yield code
    for part in code.co_consts:
        if isinstance(part, CodeType):
            yield from _codes(part)


def _is_plain(code: CodeType, known: dict[str, Any]) -> bool:
    """Whether it imports nothing, and what it reads by name are globals that are `known`, `BUILTINS` and attributes."""
    names = [step.opname for step in dis.get_instructions(code)]
    if not REACHES_FURTHER.isdisjoint(names) or any("JUMP_BACKWARD" in name for name in names):
        return False
    for name in code.co_names:
        inner = getattr(np, name) if name in IN_NUMPY else None
        is_builtin = hasattr(builtins, name) and name not in BUILTINS and inner is None
        if (name.startswith("_") or is_builtin) and name not in known:
            return False
        if isinstance(inner, ModuleType) and inner not in MODULES and name not in known:
            return False
    return True
