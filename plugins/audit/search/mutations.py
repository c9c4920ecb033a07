"""The known cheats, as changes of action sequences: stop before the end, hold, slow down, loop, finish at the end.

Each is a pure function of n pairs of parents and a generator; it returns n children, all at once.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness.arrays import Float

from .moves import Choices, Moves, Reals, Rng
from .world import Actions, Whole


@dataclass(frozen=True, eq=False)
class Pairs:
    """Parents of n children.

    Attributes:
        moves: What actions there are.
        first: Who is changed, (n, horizon, ...).
        length: How many steps its episode was long, (n,); what it had done later is there too.
        second: Whose parts may be put in, (n, horizon, ...).
        second_length: The length of that one's, (n,).
    """

    moves: Moves
    first: Actions
    length: Whole
    second: Actions
    second_length: Whole

    def __len__(self) -> int:
        return len(self.first)

    @property
    def horizon(self) -> int:
        """The most steps of an episode."""
        return int(self.first.shape[1])

    @property
    def clock(self) -> Whole:
        """The steps, (1, horizon)."""
        return np.arange(self.horizon)[None]

    def of(self, rows: NDArray[Any]) -> "Pairs":
        """Some of them."""
        return Pairs(self.moves, *(it[rows] for it in (self.first, self.length, self.second, self.second_length)))


Mutation: TypeAlias = Callable[[Pairs, Rng], Actions]


def stop_before_the_end(pairs: Pairs, rng: Rng) -> Actions:
    """The same, but for the last steps: a part of a step, then stays where it is, or goes on with the last action."""
    place = np.maximum(pairs.length - _few(rng, pairs.length), 0)[:, None]
    held = _keep(pairs.first, np.minimum(pairs.clock, np.maximum(place - 1, 0)))
    still = np.broadcast_to(pairs.moves.resting(rng, len(pairs)), held.shape)
    child = _where(pairs.clock < place, pairs.first, _where(_chance(rng, pairs, 0.6), still, held))
    partly = np.where(pairs.clock == place, rng.random((len(pairs), 1)), 0.0)
    return _where(pairs.clock == place, _eased(pairs, pairs.first, partly), child)


def hold(pairs: Pairs, rng: Rng) -> Actions:
    """From some step on the same action, for a while; then what would have come, or what came later."""
    begin, end = _window(pairs, rng)
    late = _chance(rng, pairs, 0.5)
    inside = (pairs.clock >= begin) & (pairs.clock < end)
    index = np.where(inside, begin, np.where(late & (pairs.clock >= end), pairs.clock - end + begin, pairs.clock))
    return _keep(pairs.first, index)


def stretch(pairs: Pairs, rng: Rng) -> Actions:
    """Slower or faster as a whole; often just so slowly that it ends with the episode, or would end after it."""
    count = len(pairs)
    full = pairs.horizon / np.maximum(pairs.length, 1) * np.exp(rng.normal(0.0, 0.03, count))
    free = np.exp(rng.uniform(-1.0, 2.0, count))
    factor = np.where(rng.random(count) < 0.5, full, free)[:, None]
    child = _keep(pairs.first, (pairs.clock / factor).astype(np.int64))
    return _eased(pairs, child, np.where(rng.random((count, 1)) < 0.7, 1.0 / np.maximum(factor, 1.0), 1.0))


def slow_down_from(pairs: Pairs, rng: Rng) -> Actions:
    """The same up to some step, then slower: it would come, but ever later."""
    begin = _place(rng, pairs.length)
    left = np.maximum(pairs.length[:, None] - begin, 1)
    full = np.maximum((pairs.horizon - begin) / left, 1.0) * np.exp(rng.normal(0.0, 0.05, begin.shape))
    factor = np.where(_chance(rng, pairs, 0.7), full, np.exp(rng.uniform(0.0, 3.0, begin.shape)))
    later = pairs.clock >= begin
    index = np.where(later, begin + (pairs.clock - begin) / factor, pairs.clock).astype(np.int64)
    return _eased(pairs, _keep(pairs.first, index), np.where(later, 1.0 / np.maximum(factor, 1.0), 1.0))


def repeat(pairs: Pairs, rng: Rng) -> Actions:
    """A window again and again, then the rest: often so that the rest ends with the episode."""
    begin, end = _window(pairs, rng)
    index = begin + (pairs.clock - begin) % np.maximum(end - begin, 1)
    return _keep(pairs.first, _insert(pairs, rng, end, index))


def back_and_forth(pairs: Pairs, rng: Rng) -> Actions:
    """A window backwards, then forwards, again and again, then the rest."""
    begin, end = _window(pairs, rng)
    width = np.maximum(end - begin, 1)
    phase = (pairs.clock - end) % (2 * width)
    back = phase < width
    index = _insert(pairs, rng, end, np.where(back, end - 1 - phase, end - 2 * width + phase))
    inserted, kept = (pairs.clock >= end) & (index < end), _keep(pairs.first, index)
    return _where(inserted & back, pairs.moves.turned(kept), kept)


def wait(pairs: Pairs, rng: Rng) -> Actions:
    """Keeps still at some step for a while, then goes on: later, often as late as can be."""
    begin = _place(rng, pairs.length)
    index = _insert(pairs, rng, begin, np.full((1, pairs.horizon), -1))
    still = np.broadcast_to(pairs.moves.resting(rng, len(pairs)), pairs.first.shape)
    return _where(index < 0, still, _keep(pairs.first, index))


def leave_out(pairs: Pairs, rng: Rng) -> Actions:
    """A window left out: sooner."""
    begin, end = _window(pairs, rng)
    return _keep(pairs.first, np.where(pairs.clock >= begin, pairs.clock + end - begin, pairs.clock))


def warp(pairs: Pairs, rng: Rng) -> Actions:
    """A window some steps sooner or later."""
    begin, end = _window(pairs, rng)
    by = rng.integers(1, 6, begin.shape) * rng.choice([-1, 1], begin.shape)
    return _keep(pairs.first, np.where((pairs.clock >= begin) & (pairs.clock < end), pairs.clock + by, pairs.clock))


def cross(pairs: Pairs, rng: Rng) -> Actions:
    """One up to some step, then the other: from the same step, or from any."""
    place = _place(rng, pairs.length)
    other = np.where(_chance(rng, pairs, 0.5), place, _place(rng, pairs.second_length))
    return _where(pairs.clock < place, pairs.first, _keep(pairs.second, pairs.clock - place + other))


def finish_at_the_end(pairs: Pairs, rng: Rng) -> Actions:
    """One for as long as can be, then the last steps of the other: loop, then finish in the last step."""
    tail = rng.integers(1, np.maximum(pairs.second_length, 1) + 1)[:, None]
    place = np.maximum(pairs.horizon - tail, 0)
    shifted = _keep(pairs.second, pairs.clock - place + pairs.second_length[:, None] - tail)
    return _where(pairs.clock < place, pairs.first, shifted)


def burst(pairs: Pairs, rng: Rng) -> Actions:
    """One action, any, through a window."""
    inside, drawn = _inside(pairs, rng), pairs.moves.white(rng, len(pairs), 1)
    return _where(inside, np.broadcast_to(drawn, pairs.first.shape), pairs.first)


def recolour(pairs: Pairs, rng: Rng) -> Actions:
    """Noise of any colour through a window."""
    inside = _inside(pairs, rng)
    return _where(inside, pairs.moves.coloured(rng, len(pairs), pairs.horizon), pairs.first)


def end_anew(pairs: Pairs, rng: Rng) -> Actions:
    """The same up to some step, most often one of the last, and noise of any colour from there on."""
    near = pairs.length[:, None] - _few(rng, pairs.length)[:, None]
    place = np.where(_chance(rng, pairs, 0.6), near, _place(rng, pairs.length))
    return _where(pairs.clock < place, pairs.first, pairs.moves.coloured(rng, len(pairs), pairs.horizon))


def refine(pairs: Pairs, rng: Rng) -> Actions:
    """A little noise: small numbers everywhere or through a window; of choices, a few drawn anew."""
    window = _inside(pairs, rng)
    inside = _chance(rng, pairs, 0.4) | window
    if isinstance(pairs.moves, Choices):
        rare = rng.random(inside.shape) < 10.0 ** rng.uniform(-2.0, -0.3, (len(pairs), 1))
        return _where(inside & rare, pairs.moves.white(rng, len(pairs), pairs.horizon), pairs.first)
    white = rng.normal(0.0, 1.0, pairs.first.shape)
    noise = np.where(_chance(rng, pairs, 0.5)[..., None], white, pairs.moves.coloured(rng, len(pairs), pairs.horizon))
    loud = 10.0 ** rng.uniform(-3.0, -0.3, (len(pairs), 1, 1))
    return _where(inside, _clip(pairs.first + loud * noise), pairs.first)


def blend(pairs: Pairs, rng: Rng) -> Actions:
    """Between one and the other, or a little beyond; of choices, some of each."""
    if isinstance(pairs.moves, Choices):
        return _where(rng.random(pairs.first.shape) < rng.random((len(pairs), 1)), pairs.first, pairs.second)
    share = rng.uniform(-0.3, 1.0, (len(pairs), 1, 1))
    return _clip(pairs.first + share * (pairs.second - pairs.first))


def strengthen(pairs: Pairs, rng: Rng) -> Actions:
    """Stronger or weaker through a window, up to the extremes and to the other direction."""
    inside = _inside(pairs, rng)
    factor = rng.choice([-1.0, 0.0, 0.5, 0.8, 1.25, 2.0, 1e6], (len(pairs), 1, 1))
    return _where(inside, _clip(pairs.first * factor), pairs.first)


def one_alone(pairs: Pairs, rng: Rng) -> Actions:
    """One number of all actions otherwise: noise, nothing, or the other parent's."""
    size = pairs.first.shape[2]
    chosen = rng.integers(size, size=(len(pairs), 1, 1)) == np.arange(size)
    drawn = pairs.moves.coloured(rng, len(pairs), pairs.horizon)
    which = rng.integers(3, size=(len(pairs), 1, 1))
    instead = np.where(which == 0, drawn, np.where(which == 1, 0.0, pairs.second))
    return np.where(chosen, instead, pairs.first).astype(np.float32)


def smooth(pairs: Pairs, rng: Rng) -> Actions:
    """Each action the mean of those near in time: calmer."""
    width = int(rng.integers(1, 6))
    sums = np.cumsum(np.pad(pairs.first, ((0, 0), (width + 1, width), (0, 0)), mode="edge"), axis=1, dtype=np.float64)
    return ((sums[:, 2 * width + 1 :] - sums[:, : -2 * width - 1]) / (2 * width + 1)).astype(np.float32)


ANYWHERE: tuple[Mutation, ...] = (
    stop_before_the_end, hold, stretch, slow_down_from, repeat, back_and_forth, wait, leave_out, warp, cross,
    finish_at_the_end, burst, recolour, end_anew, refine, blend,
)  # fmt: skip
"""Mutations of numbers and of choices."""
OF_NUMBERS: tuple[Mutation, ...] = (strengthen, one_alone, smooth)
"""Those of numbers alone."""


def mutations_of(moves: Moves) -> tuple[Mutation, ...]:
    """All that such actions allow."""
    return ANYWHERE + (OF_NUMBERS if isinstance(moves, Reals) else ())


def _keep(actions: Actions, index: NDArray[Any]) -> Actions:
    """The actions of other steps, (n, horizon, ...); before the first step the first, after the last one the last."""
    inside = np.clip(index, 0, actions.shape[1] - 1)
    chosen: Actions = actions[np.arange(len(actions))[:, None], inside]
    return chosen


def _where(mask: NDArray[Any], these: Actions, others: Actions) -> Actions:
    """`these` in the steps of a mask, (n, horizon)."""
    return np.where(mask.reshape(*mask.shape, *(1,) * (these.ndim - 2)), these, others).astype(these.dtype)


def _clip(actions: Float) -> Actions:
    return np.clip(actions, -1.0, 1.0).astype(np.float32)


def _eased(pairs: Pairs, child: Actions, factor: Float) -> Actions:
    """Actions times a factor, (n, horizon) or (n, 1); choices are left."""
    return child if isinstance(pairs.moves, Choices) else _clip(child * factor[..., None])


def _chance(rng: Rng, pairs: Pairs, share: float) -> NDArray[Any]:
    """Whether something is done, of each child, (n, 1)."""
    return np.asarray(rng.random((len(pairs), 1)) < share)


def _few(rng: Rng, length: Whole) -> Whole:
    """A number of steps, from 1 to `length`, each magnitude as likely, (n,)."""
    return np.exp(rng.uniform(0.0, np.log(np.maximum(length, 1) + 1.0))).astype(np.int64)


def _place(rng: Rng, length: Whole) -> Whole:
    """A step of each parent, (n, 1)."""
    return rng.integers(0, np.maximum(length, 1))[:, None]


def _window(pairs: Pairs, rng: Rng) -> tuple[Whole, Whole]:
    """Where a window of each first parent begins, and where it ends, (n, 1) each."""
    begin = _place(rng, pairs.length)
    return begin, np.minimum(begin + _few(rng, pairs.length)[:, None], np.maximum(pairs.length[:, None], 1))


def _inside(pairs: Pairs, rng: Rng) -> NDArray[Any]:
    """Which steps a window of each first parent holds, (n, horizon)."""
    begin, end = _window(pairs, rng)
    return np.asarray((pairs.clock >= begin) & (pairs.clock < end))


def _insert(pairs: Pairs, rng: Rng, place: Whole, index: Whole) -> Whole:
    """Which steps a child takes where something is put in at a place, (n, 1); the index says what, (n or 1, horizon).

    Half of them get so much that the rest of the parent's episode ends with the horizon, or just misses it.
    """
    room = np.maximum(pairs.horizon - pairs.length, 0)[:, None]
    full = np.maximum(room + rng.integers(-1, 2, room.shape), 0)
    free = _few(rng, np.maximum(pairs.horizon - place[:, 0], 1))[:, None]
    much = np.where(_chance(rng, pairs, 0.5), full, free)
    later = np.where(pairs.clock < place + much, index, pairs.clock - much)
    return np.where(pairs.clock < place, pairs.clock, later)
