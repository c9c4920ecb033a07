"""The curve of a group of runs, from which its index is read. It takes runs of any length piece by piece."""

import math
from collections.abc import Iterable, Sequence
from typing import Literal, TypeAlias

import numpy as np

from harness.arrays import Float, Mask
from harness.eta.index import Index

Kind: TypeAlias = Literal["accumulated", "per-step"]
KINDS = ("accumulated", "per-step")

POINTS = 4096
"""At least so many steps of each run are kept for resampling, at most twice as many. Shorter runs are kept whole."""
EXCHANGED = 1024
"""At most so many steps of each run enter a test, which draws thousands of curves."""


class GroupCurve:
    """Mean over the runs of a group, step by step.

    * ``accumulated``, as published: a run's curve is the running sum of its reward. I_N sums all negative values of
      the mean curve, I_P all positive ones, over the whole curve.
    * ``per-step``, NOTE eq. 39-42 read literally: a run's curve is its reward. I_N sums the mean curve up to and with
      the cross-over t_k, I_P what follows. A curve that never comes back is all I_N, one that is never negative is all
      I_P.
    """

    def __init__(self, runs: int, kind: Kind = "accumulated") -> None:
        self.kind: Kind = kind
        self.count = runs
        self._last = np.zeros(runs)
        self._steps = 0
        self._first_negative: int | None = None
        self._crossover: int | None = None
        self._sums = [0.0, 0.0]  # I_N and I_P
        self._kept: list[Float] = []
        self._kept_points = 0
        self._stride = 1

    def add(self, rewards: Float) -> None:
        """Take the next n steps of every run, (runs, n); episode-start rows are steps too."""
        if rewards.shape[1] == 0:
            return
        runs = self._curves(np.asarray(rewards, np.float64))
        start = self._steps
        self._add_mean(_mean_of(runs))
        self._keep(runs, start)

    @property
    def index(self) -> Index:
        """The index of the mean curve so far."""
        sums = self._sums
        if self.kind == "per-step" and self._first_negative is None:  # taken for I_N as long as that could be
            sums = [0.0, sums[0]]
        return Index(self._first_negative, self._crossover, self._steps, *sums)

    @property
    def runs(self) -> Float:
        """Each run's curve, every `stride`-th step of it, (runs, points)."""
        if len(self._kept) == 1:
            return self._kept[0]
        return np.concatenate(self._kept, axis=1) if self._kept else np.empty((self.count, 0))

    @property
    def stride(self) -> int:
        """Steps from one kept point to the next; 1 for short runs."""
        return self._stride

    def resample(self, shares: Float) -> tuple[Float, Float]:
        """I_N and I_P of resampled groups, (draws,) both, from the kept points.

        Args:
            shares: How much of each run enters a draw, (draws, runs), each row sums to 1.
        """
        runs, parts = self.runs, []
        for start in _chunks(shares):
            parts.append(_split(shares[start : start + _CHUNK] @ runs, self.kind))
        negative, positive = np.concatenate(parts, axis=1) * self._stride
        return negative, positive

    def left_out(self) -> tuple[Float, Float]:
        """I_N and I_P without each of the runs, (runs,) both, from the kept points; takes two runs at least."""
        count = self.count
        return self.resample((1.0 - np.eye(count)) / (count - 1))

    def each(self) -> tuple[Float, Float]:
        """I_N and I_P of each run alone, (runs,) both, from the kept points."""
        negative, positive = _split(self.runs, self.kind) * self._stride
        return negative, positive

    def _curves(self, rewards: Float) -> Float:
        if self.kind == "per-step":
            return rewards
        first = rewards[:, :1] + self._last[:, None]  # one addition after another, as for the whole run at once
        runs = np.cumsum(np.concatenate([first, rewards[:, 1:]], axis=1), axis=1)
        self._last = runs[:, -1].copy()
        return runs

    def _add_mean(self, mean: Float) -> None:
        """Go on with the mean over the runs, (n,)."""
        negative, after, start = mean < 0.0, 0, self._steps
        self._steps += len(mean)
        if self._first_negative is None and negative.any():
            after = int(np.argmax(negative))
            self._first_negative = start + after
        if self._first_negative is not None and self._crossover is None and not negative[after:].all():
            self._crossover = start + after + int(np.argmin(negative[after:]))
        if self.kind == "accumulated":
            self._sums[0] += float(np.minimum(mean, 0.0).sum())
            self._sums[1] += float(np.maximum(mean, 0.0).sum())
            return
        end = len(mean) if self._crossover is None else max(0, self._crossover + 1 - start)
        self._sums[0] += float(mean[:end].sum())
        self._sums[1] += float(mean[end:].sum())

    def _keep(self, runs: Float, start: int) -> None:
        kept = runs[:, -start % self._stride :: self._stride].copy()
        self._kept.append(kept)
        self._kept_points += kept.shape[1]
        while self._kept_points > 2 * POINTS:
            self._kept = [self.runs[:, ::2]]
            self._kept_points = self._kept[0].shape[1]
            self._stride *= 2


_CHUNK = 64


def curve_of(rewards: Sequence[Float], kind: Kind = "accumulated") -> GroupCurve:
    """The curve of runs that are in memory, each (steps,), cut to the shortest."""
    return stream_curve(rewards, len(rewards), min((len(reward) for reward in rewards), default=0), kind)


def stream_curve(rewards: Iterable[Float], runs: int, steps: int, kind: Kind = "accumulated") -> GroupCurve:
    """The curve of runs that come one after the other. Only one run at a time is in memory.

    Args:
        rewards: The rewards of each run, (steps,) or longer.
        runs: How many runs there are.
        steps: The length to which they are cut.
        kind: See `GroupCurve`.
    """
    curve = GroupCurve(runs, kind)
    if not runs or not steps:
        return curve
    stride = 1
    while math.ceil(steps / stride) > 2 * POINTS:
        stride *= 2
    kept, total = np.empty((runs, math.ceil(steps / stride))), np.zeros(steps)
    sums = np.empty(steps)  # one array for all runs: new memory would cost as much as the sums
    for row, run in zip(kept, rewards, strict=True):
        values = np.asarray(run[:steps], np.float64)
        if kind == "accumulated":
            values = np.cumsum(values, out=sums)
        row[:] = values[::stride]
        total += values
    kept += 0.0  # no -0.0, as where a run goes on from the sum before
    curve._add_mean(total / runs)
    curve._kept, curve._kept_points, curve._stride = [kept], kept.shape[1], stride
    return curve


def mixtures(groups: Sequence[GroupCurve], shares: Float) -> tuple[Float, Float]:
    """I_N and I_P of mean curves of the runs of several groups, (ways,) both, from `EXCHANGED` points at most.

    Args:
        groups: Runs, cut to the shortest group.
        shares: How much each of all runs enters a mean, (ways, runs), each row sums to 1.
    """
    runs, scale = _exchanged(groups)
    together = np.concatenate(runs)
    parts = [_split(shares[start : start + _CHUNK] @ together, groups[0].kind) for start in _chunks(shares)]
    negative, positive = np.concatenate(parts, axis=1) * scale
    return negative, positive


def swapped(one: GroupCurve, other: GroupCurve, signs: Float) -> tuple[Float, Float]:
    """I_N and I_P of two groups whose runs change places, (2, ways) of each group, from `EXCHANGED` points at most.

    It gives what `mixtures` gives for each side, in a quarter of the time. One side gains the run that the other
    side loses, so both mean curves lie equally far from their middle.

    Args:
        one: A group.
        other: A group of as many runs.
        signs: 1 where run i of both stays, -1 where it changes places, (ways, runs).
    """
    (first, second), scale = _exchanged((one, other))
    middle, apart = (first + second).sum(axis=0), second - first
    parts = []
    for start in _chunks(signs):
        away = signs[start : start + _CHUNK] @ apart
        parts.append(np.stack([_split(middle - away, one.kind), _split(middle + away, one.kind)]))
    ours, theirs = np.concatenate(parts, axis=2) * (scale / (2 * one.count))
    return ours, theirs


def _exchanged(groups: Sequence[GroupCurve]) -> tuple[list[Float], int]:
    """The kept points that enter a test, cut to the shortest group, and how many steps each point stands for."""
    stride = max(group.stride for group in groups)
    kept = [group.runs[:, :: stride // group.stride] for group in groups]
    points = min(runs.shape[1] for runs in kept)
    skip = max(1, math.ceil(points / EXCHANGED))
    return [runs[:, :points:skip] for runs in kept], stride * skip


def _chunks(ways: Float) -> range:
    """Where each piece of the ways begins. All curves at once would take gigabytes."""
    return range(0, len(ways), _CHUNK)


def _split(curves: Float, kind: Kind) -> Float:
    """I_N and I_P of each curve, (draws, points) -> (2, draws)."""
    if kind == "accumulated":
        positive = np.maximum(curves, 0.0).sum(axis=1)
        return np.stack([curves.sum(axis=1) - positive, positive])
    before = _before_crossover(curves)
    total, negative = curves.sum(axis=1), np.where(before, curves, 0.0).sum(axis=1)
    return np.stack([negative, total - negative])


def _mean_of(runs: Float) -> Float:
    """The mean by one addition after another. numpy's own mean adds in another order if there is only one column."""
    total = runs[0].copy()
    for run in runs[1:]:
        total += run
    mean: Float = total / len(runs)
    return mean


def _before_crossover(curves: Float) -> Mask:
    """Steps up to and with the cross-over, (draws, points); all False for a curve that is never negative."""
    seen_negative = np.logical_or.accumulate(curves < 0.0, axis=1)
    crossed = np.logical_or.accumulate(seen_negative & (curves >= 0.0), axis=1)
    first = crossed & ~np.pad(crossed, ((0, 0), (1, 0)))[:, :-1]
    before: Mask = (~crossed | first) & seen_negative[:, -1:]
    return before
