"""A reward of an environment pays a data set: a function is asked about one step after the other."""

import math
from itertools import chain
from typing import Any

import numpy as np

from harness.log import Rows
from harness.payoff.dataset.steps import VECTORS, Payer, each_row, infos_of, readable, seen_after, vectors_of
from harness.recorder.sealed import ReadOnlyDict
from harness.recorder.trial import Guarded
from harness.reward import Paid, Steps
from harness.reward.given import Before, Given, zeros_of
from harness.reward.steps import BEFORE, ENDS, steps_type


class Unseen:
    """Stands where an observation is not known, and notices a function that looks at it."""

    def __init__(self, told: str = "nothing is known of what came after this step") -> None:
        self.looked_at, self._why = False, told

    def __getattr__(self, name: str) -> Any:
        self._look()

    def __deepcopy__(self, memo: Any) -> "Unseen":
        return self  # to copy is not to look: functions are given copies

    def _look(self, *_: Any) -> Any:
        self.looked_at = True
        raise LookupError(self._why)

    __array__ = __bool__ = __call__ = __contains__ = __float__ = __getitem__ = __index__ = __int__ = _look
    __iter__ = __len__ = __str__ = __repr__ = __neg__ = __abs__ = __eq__ = __ne__ = __lt__ = __le__ = __gt__ = _look
    __ge__ = __add__ = __radd__ = __sub__ = __rsub__ = __mul__ = __rmul__ = __truediv__ = __rtruediv__ = _look
    __pow__ = __matmul__ = __rmatmul__ = __hash__ = __format__ = _look


class _StepByStep:
    """A reward of a step of an environment, asked about one step after the other.

    A step has what is recorded, of how it ended too. What was told before the first one of an episode, by its reset,
    is not.
    """

    def __init__(self, reward: Guarded) -> None:
        self._reward = reward
        self._before: Any = None
        self._is_blind = self._has_blanks = False

    def __call__(self, rows: Rows) -> Paid:
        if rows["step"][0] <= 1:
            self._before, self._is_blind, self._has_blanks = None, False, False
            self._reward.reset()
        for values in rows.columns.values():
            values.setflags(write=False)
        count, seen, unseen, blank = len(rows), seen_after(rows), Unseen(), Unseen("it holds no finite numbers")
        (begun, *_), comes, done = (readable(rows, name).tolist() for name in VECTORS)
        started, after, acted = (vectors_of(rows.columns, name) for name in VECTORS)
        if isinstance(after, dict) and not after:
            seen, unseen = count, Unseen(NOT_SEEN)
            observed = [unseen] * (count + 1)
        else:
            came = zip([begun, *comes[:seen]], chain(each_row(started, 1), each_row(after, seen)), strict=False)
            observed = [it if known else blank for known, it in came] + [unseen] * (count - seen)
        did = [it if known else blank for known, it in zip(done, each_row(acted, count), strict=True)]
        infos = infos_of(rows.columns)
        told = [ReadOnlyDict({key: it[row] for key, it in infos.items()}) for row in range(count)]
        first = Before(observed[0], *self._before) if self._before else _AtStart(observed[0], zeros_of(did[0]))
        before = [first, *map(Before, observed[1:], did[:-1], told)]
        ends = {name: rows[name].astype(bool).tolist() for name in ENDS if name in rows.columns}
        recorded = steps_type((*Before._fields, *ends, BEFORE))
        steps = [*map(recorded, observed[1:], did, told, *ends.values(), before)]
        self._before = did[-1], told[-1]
        self._has_blanks |= not (begun and all(comes[:seen]) and all(done))
        known = steps[:seen]
        paid = [self._with_blanks(step, blank) for step in known] if self._has_blanks else self._reward(known)
        paid += filter(None, (self._without_next(step, unseen) for step in steps[seen:]))
        if unseen.looked_at and seen == count:  # and went on
            unseen[0]
        total, *terms = np.array(paid).reshape(-1, 1 + len(self._reward.terms)).T
        return Paid(total, dict(zip(self._reward.terms, terms, strict=True)))

    def _with_blanks(self, step: Steps, blank: Unseen) -> list[float]:
        """What it pays a step; NaN from where on it looks at what is not finite, to the end of the episode."""
        if not self._is_blind:
            try:
                (paid,) = self._reward([step])
            except Exception:
                if not blank.looked_at:
                    raise
            self._is_blind = blank.looked_at
        return [math.nan] * (1 + len(self._reward.terms)) if self._is_blind else paid

    def _without_next(self, step: Steps, unseen: Unseen) -> list[float] | None:
        """What it pays a step after which nothing was seen; None of one that looks at what came then."""
        try:
            (paid,) = self._reward([step])
        except Exception:  # whatever it makes of what is not there
            return None
        return None if unseen.looked_at else paid


NOT_SEEN = "it looks at an observation, and the observations of this data set hold no numbers"
_AtStart = steps_type(("observation", "action"))


def step_by_step(name: str, given: Given) -> Payer:
    """A reward of an environment, see `harness.reward.given`, of this name.

    Raises:
        UsageError: It is none.
    """
    return _StepByStep(Guarded(given, name))
