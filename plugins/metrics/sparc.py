"""How smoothly the end effector moves, however long it takes."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.arrays import Float
from harness.record.trace import Trace

CUT_OFF = 10.0
"""Higher frequencies are left out, [Hz]."""
THRESHOLD = 0.05
"""The spectrum ends at the last frequency whose normalised magnitude is at least this."""
PADDING = 4
"""The speeds are padded with zeros to the next power of 2, times 2 to the power of this number."""
FEWEST = 4
"""An episode with fewer speeds does not count, because it has almost no spectrum."""
STANDING = 1e-6
"""An end effector whose path is shorter than this counts as standing still, [m]."""


@dataclass(frozen=True)
class Sparc:
    """Spectral arc length of the end effector's speed, mean over the finished episodes, < 0; nearer to 0 is smoother.

    The magnitude of the speed's Fourier spectrum draws a curve up to the cut-off, which is 10 Hz or half the control
    rate, whichever is lower. Both axes are scaled to the range from 0 to 1. The spectral arc length is minus the length
    of this curve (Balasubramanian et al. 2015, SPARC). Neither duration nor amplitude of the motion matter. Episodes
    with fewer than 4 steps, or without motion, do not count.
    """

    unit: ClassVar[str] = ""
    better: ClassVar[str] = "higher"
    bounds: ClassVar[tuple[float, float]] = (-math.inf, 0.0)

    def __call__(self, trace: Trace) -> float | None:
        """None if the trace does not record the control period, or if no episode counts."""
        period = trace.facts.control_period
        if period is None:
            return None
        position = np.stack([trace[f"end_effector_{axis}"] for axis in "xyz"], axis=1)
        profiles = [np.linalg.norm(np.diff(position[rows], axis=0), axis=1) for rows in trace.episodes]
        arcs = [spectral_arc(way, period) for way in profiles if len(way) >= FEWEST and way.sum() >= STANDING]
        return float(np.mean(arcs)) if arcs else None


def spectral_arc(speed: Float, period: float) -> float:
    """The spectral arc length, < 0, of a speed profile, (samples,), in any unit, with one sample per `period` [s]."""
    size = 2 ** (int(np.ceil(np.log2(len(speed)))) + PADDING)
    within = int(min(max(CUT_OFF * period * size, 1.0), size // 2)) + 1
    magnitude = np.abs(np.fft.rfft(speed, size)[:within])
    magnitude /= magnitude[0]  # the largest: speeds are not negative
    last = int(np.flatnonzero(magnitude >= THRESHOLD)[-1])
    return -float(np.hypot(1.0 / last, np.diff(magnitude[: last + 1])).sum())
