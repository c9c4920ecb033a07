"""An array that knows only the Python array API standard, to see what a reward asks of one."""

import operator
from collections.abc import Callable
from typing import Any

import numpy as np

NAMES = """
abs acos acosh add any all arange argmax argmin argsort asarray asin asinh astype atan atan2 atanh bool
broadcast_arrays broadcast_to ceil clip concat copysign cos cosh cumulative_sum divide e empty empty_like equal exp
expand_dims expm1 flip float32 float64 floor floor_divide full full_like greater greater_equal hypot inf int32 int64
isfinite isinf isnan less less_equal linspace log log10 log1p log2 logaddexp logical_and logical_not logical_or
logical_xor matmul max maximum mean min minimum moveaxis multiply nan negative newaxis not_equal ones ones_like
permute_dims pi positive pow prod reciprocal remainder repeat reshape roll round searchsorted sign signbit sin sinh
sort sqrt square squeeze stack std subtract sum take tan tanh tile trunc unstack var vecdot where zeros zeros_like
"""
STANDARD = frozenset(NAMES.split())
"""The names of the Python array API standard that a reward may need."""
REDUCTIONS = ("sum", "mean", "max", "min", "prod", "any", "all")
"""Methods that an array has too, so that ``(step.action**2).sum(-1)``, which everybody writes, is allowed.

The standard has them as functions only. But numpy's and JAX's arrays have all of these methods. Torch's have them too,
except that ``max`` and ``min`` along an axis return the places as well.
"""


class StandardArray:
    """An array of which nothing is known but the Python array API standard: not numpy's, not to be changed.

    It has arithmetic, comparisons, indexing, shape, dtype and `REDUCTIONS`; the rest is in its namespace. It gives away
    no truth value and no numpy array, like an array inside a compiled JAX function.
    """

    __array_ufunc__ = None
    __hash__ = None  # type: ignore[assignment]  # as any array: compared element by element

    def __init__(self, values: Any) -> None:
        self.values = np.asarray(values)

    @property
    def shape(self) -> tuple[int, ...]:
        """The same as numpy's."""
        return self.values.shape

    @property
    def ndim(self) -> int:
        """The same as numpy's."""
        return self.values.ndim

    @property
    def dtype(self) -> Any:
        """The same as numpy's."""
        return self.values.dtype

    def __array_namespace__(self, *, api_version: str | None = None) -> "StandardNamespace":
        return StandardNamespace()

    def __getitem__(self, key: Any) -> "StandardArray":
        return StandardArray(self.values[_bare(key)])

    def __bool__(self) -> bool:
        raise TypeError("the value decides which way the code goes: use where()")

    def __array__(self, *_: Any, **__: Any) -> Any:
        raise TypeError("numpy was asked to compute on an array of another library: use __array_namespace__()")


def _operator(function: Callable[..., Any], *, swapped: bool = False) -> Callable[..., Any]:
    def apply(self: StandardArray, *others: Any) -> Any:
        if any(isinstance(other, np.ndarray) for other in others):
            return NotImplemented
        given = [self.values, *map(_bare, others)]
        return StandardArray(function(*reversed(given) if swapped else given))

    return apply


for _name in ("add", "sub", "mul", "truediv", "floordiv", "mod", "pow", "and", "or", "xor"):
    _function = getattr(operator, f"__{_name}__")
    setattr(StandardArray, f"__{_name}__", _operator(_function))
    setattr(StandardArray, f"__r{_name}__", _operator(_function, swapped=True))
for _name in ("lt", "le", "gt", "ge", "eq", "ne", "neg", "pos", "abs", "invert"):
    setattr(StandardArray, f"__{_name}__", _operator(getattr(operator, f"__{_name}__")))


def _reduction(name: str) -> Callable[..., StandardArray]:
    def reduce(self: StandardArray, axis: Any = None, keepdims: bool = False) -> StandardArray:
        return StandardArray(getattr(np, name)(self.values, axis=axis, keepdims=keepdims))

    return reduce


for _name in REDUCTIONS:
    setattr(StandardArray, _name, _reduction(_name))


class StandardNamespace:
    """The namespace of `StandardArray`: the functions of the standard, computed by numpy."""

    def __getattr__(self, name: str) -> Any:
        if name not in STANDARD:
            raise AttributeError(f"'{name}' is not in the Python array API standard")
        found = getattr(np, name)
        if isinstance(found, type) or not callable(found):
            return found
        return lambda *args, **kwargs: _wrapped(
            found(*map(_bare, args), **{key: _bare(value) for key, value in kwargs.items()})
        )


def _bare(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        raise TypeError("an array of numpy among arrays of another library: make it with their namespace")
    if isinstance(value, StandardArray):
        return value.values
    return type(value)(map(_bare, value)) if isinstance(value, tuple | list) else value


def _wrapped(value: Any) -> Any:
    if isinstance(value, tuple | list):
        return tuple(map(_wrapped, value))
    return StandardArray(value) if isinstance(value, np.ndarray | np.generic) else value
