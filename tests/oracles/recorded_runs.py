"""Episodes that somebody recorded, before they are written in one format or the other."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.random import default_rng
from numpy.typing import NDArray

from tests.oracles.answers import Told, auc_within_tasks

EIGHTH = 0.125
"""Rewards are multiples of it: their sums are exact in any order and in 32 bits."""


@dataclass(frozen=True, eq=False)
class Run:
    """One episode.

    Attributes:
        states: Before each step and after the last, (steps + 1, 3), float32.
        actions: (steps, 2), float32.
        rewards: (steps,), float32.
        success: After each step, 0, 1, or what else stands there, (steps,), float64.
        task: Its number.
    """

    states: NDArray[np.float32]
    actions: NDArray[np.float32]
    rewards: NDArray[np.float32]
    success: NDArray[np.float64]
    task: int

    def __len__(self):
        return len(self.rewards)

    @property
    def told(self):
        """What it says: a success if one step is told to be one, unknown if no step has a label that is 0 or 1."""
        labels = [value for value in self.success.tolist() if value in (0.0, 1.0)]
        body = b"".join(part.tobytes() for part in (self.states[:-1], self.actions, self.rewards))
        return Told(float(np.sum(self.rewards, dtype=np.float64)), any(labels) if labels else None, self.task, body)


def draw_runs(rng, tasks=1):
    """Episodes of all lengths, successes and failures of each task."""
    draw = default_rng(rng.randrange(2**32))
    better = rng.choice((-1.0, 0.0, 0.5, 1.0, 2.0))
    runs = []
    for task in range(tasks):
        level = 40.0 * draw.integers(-2, 3)
        kinds = [True, False, *(rng.random() < 0.5 for _ in range(rng.randrange(4, 14)))]
        runs += [_draw_run(rng, draw, kind, task, level + better * kind) for kind in kinds]
    rng.shuffle(runs)
    return runs


def _draw_run(rng, draw, success, task, level):
    steps = rng.choice((1, 2, 3, 4, 5, 7, 9, 12))
    told = np.zeros(steps)
    if success:
        told[rng.randrange(steps) if rng.random() < 0.4 else steps - 1 :] = 1.0
    rewards = EIGHTH * draw.integers(-8, 9, steps)
    rewards[-1] += np.round(level / EIGHTH) * EIGHTH
    states = draw.normal(size=(steps + 1, 3)).astype(np.float32)
    return Run(states, draw.normal(size=(steps, 2)).astype(np.float32), rewards.astype(np.float32), told, task)


def answer_of(runs):
    """What an audit of these has to say."""
    told = [run.told for run in runs]
    return {
        "auc": auc_within_tasks(told),
        "successes": sum(one.success is True for one in told),
        "failures": sum(one.success is False for one in told),
    }


def with_rewards(run, rewards):
    """The same episode, paid otherwise."""
    return replace(run, rewards=np.asarray(rewards, np.float32))


def changed_at(runs, place, change):
    """The same episodes but for one."""
    return [change(run) if number == place else run for number, run in enumerate(runs)]


# Changes that matter, of which the answer follows: each gives other episodes.


def move_pay(runs, rng):
    """The last step of an episode pays much more, or much less."""

    def pay(run):
        rewards = run.rewards.copy()
        rewards[-1] += np.float32(rng.choice((-500.0, 500.0)))
        return with_rewards(run, rewards)

    return changed_at(runs, rng.randrange(len(runs)), pay)


def turn_label(runs, rng):
    """A success becomes a failure, or the other way around; in its last step alone."""

    def turn(run):
        told = np.zeros(len(run))
        told[-1] = 0.0 if run.success.any() else 1.0
        return replace(run, success=told)

    return changed_at(runs, rng.randrange(len(runs)), turn)


def unlabel(runs, rng):
    """Some episodes have NaN, or -1, for a label."""
    unknown = rng.choice((np.nan, -1.0))
    chosen = set(rng.sample(range(len(runs)), rng.randrange(1, max(2, len(runs) // 3))))
    return [
        replace(run, success=np.full(len(run), unknown)) if number in chosen else run for number, run in enumerate(runs)
    ]


def shift_pay(runs, rng):
    """All rewards stand a row later; the first of all is that of the last."""
    flat = np.roll(np.concatenate([run.rewards for run in runs]), 1)
    begins = np.cumsum([0, *map(len, runs)])
    return [with_rewards(run, flat[a:b]) for run, a, b in zip(runs, begins, begins[1:], strict=False)]


def other_task(runs, rng):
    """An episode is of another task."""
    last = max(run.task for run in runs)
    return changed_at(runs, rng.randrange(len(runs)), lambda run: replace(run, task=(run.task + 1) % (last + 1)))


def turn_all(runs, rng):
    """Every reward has the other sign."""
    return [with_rewards(run, -run.rewards) for run in runs]


MATTERS = (move_pay, turn_label, unlabel, shift_pay, turn_all)

# Changes that must not matter.


def reorder(runs, rng):
    """In another order."""
    return rng.sample(list(runs), len(runs))


def scale(runs, rng):
    """All rewards in another unit; by a power of two, which is exact."""
    factor = np.float32(rng.choice((0.25, 4.0, 1024.0)))
    return [with_rewards(run, run.rewards * factor) for run in runs]


def renumber_tasks(runs, rng):
    """Tasks have other numbers."""
    last = max(run.task for run in runs)
    numbers = rng.sample(range(last + 1), last + 1)
    return [replace(run, task=numbers[run.task]) for run in runs]


def leave(runs, rng):
    """As they are."""
    return list(runs)


NO_MATTER = (leave, leave, reorder, scale, renumber_tasks)
