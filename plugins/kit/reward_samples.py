"""The steps that rewards are tried with, and an array that knows nothing but the Python array API standard."""

import copy
import operator
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from harness import Float
from harness.reward import Array, Carry, Paid, Reward, Steps, pay as pay_aloud
from harness.reward.steps import DISTANCE, ENDS, map_steps, step_between
from harness.reward.terms import SIZES, call_noted, made_up

STEPS, NUM_ENVS = 20, 4
HORIZON = 100
"""Steps of a whole episode of the default task, ``fd100-reach``."""
PERIOD = 0.1
"""Seconds of its control period."""


def random_samples(seed: int, num_envs: int = NUM_ENVS, steps: int = STEPS, joints: int = SIZES[0]) -> list[Steps]:
    """The steps of an episode of each env, with the fields of `harness.reward.steps.ARM`; one per step.

    The distance goes up and down at random, and the end effector is so far from the target. The joints move as fast as
    the action says.
    """
    rng = np.random.default_rng(seed)
    begin = rng.uniform(0.2, 1.0, num_envs)
    distances = [begin]
    for _ in range(steps):
        distances.append(np.abs(distances[-1] + rng.uniform(-0.2, 0.18, num_envs)))
    states = _wandering(np.stack(distances), joints, np.random.default_rng([seed, 1]))
    best = np.minimum.accumulate(states[DISTANCE], axis=0)
    rows = [{name: values[row] for name, values in states.items()} for row in range(steps + 1)]
    return [sample_of(rows[step - 1], rows[step], begin, best[step - 1], step) for step in range(1, steps + 1)]


def samples_for(reward: Reward, seed: int, num_envs: int = NUM_ENVS, steps: int = STEPS) -> list[Steps]:
    """The same of an arm with as many joints as the reward is for."""
    return random_samples(seed, num_envs, steps, joints_of(reward))


def edge_samples(joints: int = SIZES[0]) -> list[Steps]:
    """The corners: on the target, come onto it, gone from it, standing still, back at the best, back at the start.

    In the first step nothing moves, and all else is 0; in the second one everything moves at once.
    """
    begin = np.array([0.5, 0.5, 0.5, 0.5, 0.5, 0.5])
    best = np.array([0.0, 0.3, 0.0, 0.3, 0.3, 0.5])
    previous = np.array([0.0, 0.3, 0.0, 0.3, 0.4, 0.6])
    distance = np.array([0.0, 0.0, 0.2, 0.3, 0.3, 0.5])
    before, still = state_at(previous, joints), state_at(distance, joints)
    moving = {**state_at(distance, joints, speed=1.0), "ground": np.ones(len(begin), bool)}
    return [sample_of(before, after, begin, best, step) for step, after in enumerate((still, moving), 1)]


def state_at(distance: Array, joints: int, speed: float = 0.0) -> dict[str, Any]:
    """The state of arms whose targets at the origin are `distance` away, (n,).

    All joints were told to move from 0 at `speed`, [rad/s], and did so for a step.
    """
    count = len(distance)
    speeds = np.full((count, joints), speed)
    end_effector = np.stack([distance, np.zeros(count), np.zeros(count)], axis=1)
    moved = {"qpos": PERIOD * speeds, "qvel": speeds, "action": speeds}
    places = {"end_effector": end_effector, "target": np.zeros((count, 3))}
    return {DISTANCE: distance, **moved, **places, **dict.fromkeys(("ground", *ENDS), np.zeros(count, bool))}


def sample_of(state: Mapping[str, Any], after: Mapping[str, Any], begin: Array, best: Array, step: int) -> Steps:
    """The step from one state to another, in arrays of its own."""
    return map_steps(np.array, step_between(state, after, begin, best, np.full(len(begin), step)))


def joints_of(reward: Reward) -> int:
    """How many joints the arm may have that a reward is for: the first of `SIZES` whose made-up steps it pays."""
    asked = copy.deepcopy(reward)  # what it may keep is no matter of the checks
    for size in SIZES:
        try:
            call_noted(asked, made_up(size, size))
        except Exception:  # as an index beyond the joints; a check says it of a reward that fails with all
            continue
        return size
    return SIZES[0]


def pay(reward: Reward, carry: Carry, steps: Steps) -> tuple[Carry, Paid]:
    """What the reward pays, numpy's warnings off: it may divide by anything where it then takes another value."""
    with np.errstate(all="ignore"):
        return pay_aloud(reward, carry, steps)


def play(reward: Reward, samples: list[Steps]) -> tuple[list[Carry], list[Paid]]:
    """An episode: the carry before each step and after the last one, and what each step is paid."""
    carries, paid = [reward.initial_carry(samples[0].begin_distance)], []
    for sample in samples:
        carry, value = pay(reward, carries[-1], sample)
        carries.append(carry)
        paid.append(value)
    return carries, paid


def values_of(paid: Paid) -> dict[str, Array]:
    """What a step is paid in all, and in each term, by what sentences call it."""
    return {"the value": paid.total, **{f"the term '{name}'": value for name, value in paid.terms.items()}}


def _wandering(distances: Float, joints: int, rng: np.random.Generator) -> dict[str, Any]:
    """States, (steps + 1, num_envs, ...), of arms that start at rest and are told to move at random."""
    count, num_envs = distances.shape
    action = rng.uniform(-1.0, 1.0, (count, num_envs, joints))
    action[0] = 0.0
    direction = np.cumsum(rng.normal(0.0, 0.1, (count, num_envs, 3)), axis=0) + rng.normal(size=(num_envs, 3))
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    target = np.broadcast_to(rng.uniform(0.1, 0.5, (num_envs, 3)), (count, num_envs, 3))
    ground = rng.uniform(size=distances.shape) < 0.05
    ground[0] = False
    return {
        DISTANCE: distances,
        "qpos": rng.uniform(-0.5, 0.5, (num_envs, joints)) + PERIOD * np.cumsum(action, axis=0),
        "qvel": action.copy(),
        "action": action,
        "end_effector": target + distances[..., None] * direction,
        "target": target,
        "ground": ground,
        "terminated": ground,
        "truncated": np.zeros_like(ground),
    }


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
