"""How smoothly the end effector moves, however long it takes."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from harness.arrays import Float
from harness.log import Log
from harness.record.episode_facts import episode_facts

CUT_OFF = 10.0
"""Higher frequencies are left out, [Hz]."""
THRESHOLD = 0.05
"""The spectrum ends at the last frequency whose normalised magnitude is at least this."""
PADDING = 4
"""The speeds are padded with zeros to the next power of 2, times 2 to the power of this number."""
FEWEST = 4
"""An episode with fewer speeds does not count, because it has almost no spectrum."""
BATCH = 1024
"""So many episodes are transformed together."""
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

    def __call__(self, trace: Log) -> float | None:
        """None if the trace does not record the control period, or if no episode counts."""
        period = episode_facts(trace).control_period
        if period is None or not trace.episodes:
            return None
        position = np.stack([trace[f"end_effector_{axis}"] for axis in "xyz"], axis=1)
        speed = np.linalg.norm(np.diff(position[np.concatenate(trace.episodes)], axis=0), axis=1)
        lengths = [*map(len, trace.episodes)]  # what lies between two episodes is no speed
        profiles = [speed[end - length : end - 1] for length, end in zip(lengths, np.cumsum(lengths), strict=True)]
        moved = [way for way in profiles if len(way) >= FEWEST and way.sum() >= STANDING]
        arcs = [arc for at in range(0, len(moved), BATCH) for arc in spectral_arcs(moved[at : at + BATCH], period)]
        return float(np.mean(arcs)) if arcs else None


def spectral_arcs(speeds: Sequence[Float], period: float) -> list[float]:
    """The spectral arc length, < 0, of each speed profile, (samples,), in any unit, with a sample per `period` [s]."""
    arcs = [0.0] * len(speeds)
    sizes = [2 ** ((len(speed) - 1).bit_length() + PADDING) for speed in speeds]
    for size in set(sizes):  # profiles that are padded alike are transformed together
        alike = [number for number, own in enumerate(sizes) if own == size]
        padded = np.zeros((len(alike), size >> PADDING))
        for row, number in zip(padded, alike, strict=True):
            row[: len(speeds[number])] = speeds[number]
        within = int(min(max(CUT_OFF * period * size, 1.0), size // 2)) + 1
        magnitudes = np.abs(np.fft.rfft(padded, size)[:, :within])
        magnitudes /= magnitudes[:, :1]  # the largest: speeds are not negative
        lasts = within - 1 - (magnitudes[:, ::-1] >= THRESHOLD).argmax(axis=1)
        for number, magnitude, last in zip(alike, magnitudes, lasts.tolist(), strict=True):
            arcs[number] = -float(np.hypot(1.0 / last, magnitude[1 : last + 1] - magnitude[:last]).sum())
    return arcs
