"""Broken metrics."""

import time
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from . import mutant


@dataclass(frozen=True)
class Sound:
    """The share of finished episodes that reach the target."""

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"

    def __call__(self, trace):
        return share_reached(trace)


def share_reached(trace):
    """The value of `Sound`."""
    reached = [trace["reached"][rows].any() for rows in trace.episodes]
    return float(np.mean(reached)) if reached else None


def tells(value):
    """A metric of another value, where the trace has rows."""
    return mutant(Sound, __call__=lambda self, trace: value(trace) if len(trace) else None)


def product(trace):
    """Of something of every row, where it overflows."""
    with np.errstate(over="ignore"):
        factor = float(np.prod(np.full(len(trace), 2.0)))
    return share_reached(trace) if np.isfinite(factor) else factor


class RemembersOnSelf(Sound):
    """It tells the change since the trace before, where there is one."""

    known = 0.0

    def __call__(self, trace):
        value = float(trace["distance"][trace.last_rows].sum())
        known = 0.0 if value == self.known else self.known
        object.__setattr__(self, "known", value)
        return value - known if len(trace) else None


SOUND = (Sound(),)
MUTANTS = {
    "overflows in a long trace": ("metric-finite", tells(product), "the value is inf for a trace of 2,871 rows"),
    "divides by nothing": (
        "metric-finite",
        tells(lambda t: np.nan if share_reached(t) == 0.0 else share_reached(t)),
        "the value is nan",
    ),
    "needs facts": (
        "metric-finite",
        tells(lambda t: share_reached(t) * t.facts.episodes.horizon),
        "raised TypeError: unsupported",
    ),
    "counts": ("metric-finite", tells(lambda t: int(t["reached"].sum())), "the value is a int"),
    "better is neither": ("metric-unit", mutant(Sound, better="best")),
    "nothing is zero": ("metric-empty", mutant(Sound, __call__=lambda self, t: share_reached(t) if len(t) else 0.0)),
    "never tells": ("metric-defined", tells(lambda t: None)),
    "reads the reward": ("metric-no-reward", tells(lambda t: float(t["reward"][t.last_rows].mean()))),
    "looks at the last row": ("metric-unfinished", tells(lambda t: float(t["distance"][-1]))),
    "remembers on itself": ("metric-traces", RemembersOnSelf()),
    "slow": ("metric-slow", tells(lambda t: time.sleep(6e-5 * len(t)) or 1.0), "the value of a trace of"),
    "sorts the trace": (
        "metric-arguments",
        mutant(Sound, __call__=lambda self, t: t["distance"].sort() or share_reached(t)),
    ),
}
