"""The known cheats, as changes of action sequences: stop before the end, hold, slow down, loop, finish at the end.

Each is a function of n pairs of parents, and of the generator that they bring; it returns n children, all at once.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from harness import Float, Ints

from .moves import Choices, Moves, Reals
from .world import Actions, Rng


@dataclass(frozen=True, eq=False)
class Pairs:
    """Parents of n children.

    Attributes:
        moves: What actions there are.
        rng: What draws how they are changed.
        first: Who is changed, (n, horizon, ...).
        length: How many steps its episode was long, (n,); what it had done later is there too.
        second: Whose parts may be put in, (n, horizon, ...).
        second_length: The length of that one's, (n,).
    """

    moves: Moves
    rng: Rng
    first: Actions
    length: Ints
    second: Actions
    second_length: Ints

    def __len__(self) -> int:
        return len(self.first)

    @property
    def horizon(self) -> int:
        """The most steps of an episode."""
        return int(self.first.shape[1])

    @property
    def clock(self) -> Ints:
        """The steps, (1, horizon)."""
        return np.arange(self.horizon)[None]


Mutation: TypeAlias = Callable[[Pairs], Actions]


def stop_before_the_end(pairs: Pairs) -> Actions:
    """The same, but for the last steps: a part of a step, then stays where it is, or goes on with the last action."""
    place = np.maximum(pairs.length - _few(pairs, pairs.length), 0)[:, None]
    held = _keep(pairs.first, np.minimum(pairs.clock, np.maximum(place - 1, 0)))
    still = pairs.moves.resting(pairs.rng, len(pairs))
    child = _where(pairs.clock < place, pairs.first, _where(_chance(pairs, 0.6), still, held))
    partly = np.where(pairs.clock == place, pairs.rng.random((len(pairs), 1)), 0.0)
    return _where(pairs.clock == place, _eased(pairs, pairs.first, partly), child)


def hold(pairs: Pairs) -> Actions:
    """From some step on the same action, for a while; then what would have come, or what came later."""
    begin, end = _window(pairs)
    late = _chance(pairs, 0.5)
    inside = (pairs.clock >= begin) & (pairs.clock < end)
    index = np.where(inside, begin, np.where(late & (pairs.clock >= end), pairs.clock - end + begin, pairs.clock))
    return _keep(pairs.first, index)


def stretch(pairs: Pairs) -> Actions:
    """Slower or faster as a whole; often just so slowly that it ends with the episode, or would end after it."""
    count = len(pairs)
    full = pairs.horizon / np.maximum(pairs.length, 1) * np.exp(pairs.rng.normal(0.0, 0.03, count))
    free = np.exp(pairs.rng.uniform(-1.0, 2.0, count))
    factor = np.where(pairs.rng.random(count) < 0.5, full, free)[:, None]
    child = _keep(pairs.first, (pairs.clock / factor).astype(np.int64))
    return _eased(pairs, child, np.where(pairs.rng.random((count, 1)) < 0.7, 1.0 / np.maximum(factor, 1.0), 1.0))


def slow_down_from(pairs: Pairs) -> Actions:
    """The same up to some step, then slower: it would come, but ever later."""
    begin = _place(pairs, pairs.length)
    left = np.maximum(pairs.length[:, None] - begin, 1)
    full = np.maximum((pairs.horizon - begin) / left, 1.0) * np.exp(pairs.rng.normal(0.0, 0.05, begin.shape))
    factor = np.where(_chance(pairs, 0.7), full, np.exp(pairs.rng.uniform(0.0, 3.0, begin.shape)))
    later = pairs.clock >= begin
    index = np.where(later, begin + (pairs.clock - begin) / factor, pairs.clock).astype(np.int64)
    return _eased(pairs, _keep(pairs.first, index), np.where(later, 1.0 / np.maximum(factor, 1.0), 1.0))


def repeat(pairs: Pairs) -> Actions:
    """A window again and again, then the rest: often so that the rest ends with the episode."""
    begin, end = _window(pairs)
    index = begin + (pairs.clock - begin) % np.maximum(end - begin, 1)
    return _keep(pairs.first, _insert(pairs, end, index))


def back_and_forth(pairs: Pairs) -> Actions:
    """A window backwards, then forwards, again and again, then the rest."""
    begin, end = _window(pairs)
    width = np.maximum(end - begin, 1)
    phase = (pairs.clock - end) % (2 * width)
    back = phase < width
    index = _insert(pairs, end, np.where(back, end - 1 - phase, end - 2 * width + phase))
    inserted, kept = (pairs.clock >= end) & (index < end), _keep(pairs.first, index)
    return _where(inserted & back, pairs.moves.turned(kept), kept)


def wait(pairs: Pairs) -> Actions:
    """Keeps still at some step for a while, then goes on: later, often as late as can be."""
    begin = _place(pairs, pairs.length)
    index = _insert(pairs, begin, np.full((1, pairs.horizon), -1))
    return _where(index < 0, pairs.moves.resting(pairs.rng, len(pairs)), _keep(pairs.first, index))


def leave_out(pairs: Pairs) -> Actions:
    """A window left out: sooner."""
    begin, end = _window(pairs)
    return _keep(pairs.first, np.where(pairs.clock >= begin, pairs.clock + end - begin, pairs.clock))


def warp(pairs: Pairs) -> Actions:
    """A window some steps sooner or later."""
    begin, end = _window(pairs)
    by = pairs.rng.integers(1, 6, begin.shape) * pairs.rng.choice([-1, 1], begin.shape)
    return _keep(pairs.first, np.where((pairs.clock >= begin) & (pairs.clock < end), pairs.clock + by, pairs.clock))


def cross(pairs: Pairs) -> Actions:
    """One up to some step, then the other: from the same step, or from any."""
    place = _place(pairs, pairs.length)
    other = np.where(_chance(pairs, 0.5), place, _place(pairs, pairs.second_length))
    return _where(pairs.clock < place, pairs.first, _keep(pairs.second, pairs.clock - place + other))


def finish_at_the_end(pairs: Pairs) -> Actions:
    """One for as long as can be, then the last steps of the other: loop, then finish in the last step."""
    tail = pairs.rng.integers(1, np.maximum(pairs.second_length, 1) + 1)[:, None]
    place = np.maximum(pairs.horizon - tail, 0)
    shifted = _keep(pairs.second, pairs.clock - place + pairs.second_length[:, None] - tail)
    return _where(pairs.clock < place, pairs.first, shifted)


def burst(pairs: Pairs) -> Actions:
    """One action, any, through a window."""
    inside, drawn = _inside(pairs), pairs.moves.white(pairs.rng, len(pairs), 1)
    return _where(inside, drawn, pairs.first)


def recolour(pairs: Pairs) -> Actions:
    """Noise of any colour through a window."""
    inside = _inside(pairs)
    return _where(inside, _coloured(pairs), pairs.first)


def end_anew(pairs: Pairs) -> Actions:
    """The same up to some step, most often one of the last, and noise of any colour from there on."""
    near = pairs.length[:, None] - _few(pairs, pairs.length)[:, None]
    place = np.where(_chance(pairs, 0.6), near, _place(pairs, pairs.length))
    return _where(pairs.clock < place, pairs.first, _coloured(pairs))


def refine(pairs: Pairs) -> Actions:
    """A little noise: small numbers everywhere or through a window; of choices, a few drawn anew."""
    window = _inside(pairs)
    inside = _chance(pairs, 0.4) | window
    if isinstance(pairs.moves, Choices):
        rare = pairs.rng.random(inside.shape) < 10.0 ** pairs.rng.uniform(-2.0, -0.3, (len(pairs), 1))
        return _where(inside & rare, pairs.moves.white(pairs.rng, len(pairs), pairs.horizon), pairs.first)
    white = pairs.rng.normal(0.0, 1.0, pairs.first.shape)
    noise = np.where(_chance(pairs, 0.5)[..., None], white, _coloured(pairs))
    loud = 10.0 ** pairs.rng.uniform(-3.0, -0.3, (len(pairs), 1, 1))
    return _where(inside, _clip(pairs.first + loud * noise), pairs.first)


def blend(pairs: Pairs) -> Actions:
    """Between one and the other, or a little beyond; of choices, some of each."""
    if isinstance(pairs.moves, Choices):
        return _where(
            pairs.rng.random(pairs.first.shape) < pairs.rng.random((len(pairs), 1)), pairs.first, pairs.second
        )
    share = pairs.rng.uniform(-0.3, 1.0, (len(pairs), 1, 1))
    return _clip(pairs.first + share * (pairs.second - pairs.first))


def strengthen(pairs: Pairs) -> Actions:
    """Stronger or weaker through a window, up to the extremes and to the other direction."""
    inside = _inside(pairs)
    factor = pairs.rng.choice([-1.0, 0.0, 0.5, 0.8, 1.25, 2.0, 1e6], (len(pairs), 1, 1))
    return _where(inside, _clip(pairs.first * factor), pairs.first)


def one_alone(pairs: Pairs) -> Actions:
    """One number of all actions otherwise: noise, nothing, or the other parent's."""
    size = pairs.first.shape[2]
    chosen = pairs.rng.integers(size, size=(len(pairs), 1, 1)) == np.arange(size)
    drawn = _coloured(pairs)
    which = pairs.rng.integers(3, size=(len(pairs), 1, 1))
    instead = np.where(which == 0, drawn, np.where(which == 1, 0.0, pairs.second))
    return np.where(chosen, instead, pairs.first).astype(np.float32)


def smooth(pairs: Pairs) -> Actions:
    """Each action the mean of those near in time: calmer."""
    width = int(pairs.rng.integers(1, 6))
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


def _coloured(pairs: Pairs) -> Actions:
    """Noise of any colour, an episode for each child, (n, horizon, ...)."""
    return pairs.moves.coloured(pairs.rng, len(pairs), pairs.horizon)


def _chance(pairs: Pairs, share: float) -> NDArray[Any]:
    """Whether something is done, of each child, (n, 1)."""
    return np.asarray(pairs.rng.random((len(pairs), 1)) < share)


def _few(pairs: Pairs, length: Ints) -> Ints:
    """A number of steps, from 1 to `length`, each magnitude as likely, (n,)."""
    return np.exp(pairs.rng.uniform(0.0, np.log(np.maximum(length, 1) + 1.0))).astype(np.int64)


def _place(pairs: Pairs, length: Ints) -> Ints:
    """A step of each parent, (n, 1)."""
    return pairs.rng.integers(0, np.maximum(length, 1))[:, None]


def _window(pairs: Pairs) -> tuple[Ints, Ints]:
    """Where a window of each first parent begins, and where it ends, (n, 1) each."""
    begin = _place(pairs, pairs.length)
    return begin, np.minimum(begin + _few(pairs, pairs.length)[:, None], np.maximum(pairs.length[:, None], 1))


def _inside(pairs: Pairs) -> NDArray[Any]:
    """Which steps a window of each first parent holds, (n, horizon)."""
    begin, end = _window(pairs)
    return np.asarray((pairs.clock >= begin) & (pairs.clock < end))


def _insert(pairs: Pairs, place: Ints, index: Ints) -> Ints:
    """Which steps a child takes where something is put in at a place, (n, 1); the index says what, (n or 1, horizon).

    Half of them get so much that the rest of the parent's episode ends with the horizon, or just misses it.
    """
    room = np.maximum(pairs.horizon - pairs.length, 0)[:, None]
    full = np.maximum(room + pairs.rng.integers(-1, 2, room.shape), 0)
    free = _few(pairs, np.maximum(pairs.horizon - place[:, 0], 1))[:, None]
    much = np.where(_chance(pairs, 0.5), full, free)
    later = np.where(pairs.clock < place + much, index, pairs.clock - much)
    return np.where(pairs.clock < place, pairs.clock, later)
