"""A point on a line that docks at 1: everything that pays there is known in closed form. All episodes at once."""

import numpy as np
from gymnasium.spaces import Box, Discrete
from numpy.random import default_rng

from harness_plugins.audit.search.world import Outcomes, Shown


class Dock:
    """Begins between -0.1 and 0.1, drawn by the seed; moves by at most a stride a step; docks at 1, which ends it.

    `pays` says of (before, moved, after, docked), (n,) each, what a step pays. Choices are back, stay and forth.
    """

    def __init__(self, pays, horizon=40, gamma=1.0, is_discrete=False, tells=False, stride=0.1):
        self.pays, self.horizon, self.gamma, self.is_discrete, self.stride = pays, horizon, gamma, is_discrete, stride
        self.space = Discrete(3) if is_discrete else Box(-1.0, 1.0, (1,))
        self.observes = Box(-np.inf, np.inf, (1,))
        self.name, self.reward, self.success, self.is_repeated = "dock", "own", "docked", True
        self.together, self.taken, self.directions, self.notes, self.tells = 64, 0, {}, (), tells

    def begins(self, starts):
        seeds, which = np.unique(starts, return_inverse=True)
        return np.array([default_rng(seed).uniform(-0.1, 0.1) for seed in seeds])[which]

    def play(self, starts, actions):
        speeds = (actions - 1.0 if self.is_discrete else np.clip(actions[..., 0], -1.0, 1.0)) * self.stride
        at, count = self.begins(starts), len(starts)
        paid, discounted, steps, near = np.zeros(count), np.zeros(count), np.zeros(count, int), np.full(count, -np.inf)
        running, docked, trails = np.ones(count, bool), np.zeros(count, bool), [at.copy()]
        for step in range(self.horizon):
            after = np.where(running, at + speeds[:, step], at)
            docked |= running & (after >= 1.0)
            pay = np.where(running, self.pays(at, speeds[:, step], after, docked), 0.0)
            paid, discounted = paid + pay, discounted + self.gamma**step * pay
            steps, at, near = steps + running, after, np.maximum(near, after)
            running = running & ~docked
            trails.append(at.copy())
        self.taken += int(steps.sum())
        walked = np.stack(trails, axis=1)
        return Outcomes(
            steps=steps,
            paid=paid,
            discounted=discounted,
            success=docked,
            time=np.where(docked, steps, self.horizon),
            share=np.where(docked, 1.0 / steps, 0.0),
            near=near if self.tells else np.full(count, np.nan),
            measures={"place": at},
            trails=[] if self.tells else [row[: k + 1, None] for row, k in zip(walked, steps, strict=True)],
        )

    def show(self, start, actions):
        rest = iter(actions)
        return self.watch(start, lambda seen: next(rest))

    def watch(self, start, policy):
        """What it observes does not matter to who asks whether it is a table, or chance."""
        actions = np.array([policy(np.zeros(1)) for _ in range(self.horizon)])
        steps = int(self.play(np.array([start]), actions[np.newaxis]).steps[0])
        seen = tuple(np.array([start, step]) for step in range(steps + 1))
        return Shown(start, actions[:steps], np.zeros(steps), {}, np.zeros(steps, bool), {}, "truncated", seen)


def sparse(before, moved, after, docked):
    """1 for docking."""
    return docked * 1.0


def honest(before, moved, after, docked):
    """What is left to go, as a cost, and 1 for docking."""
    return docked * 1.0 - np.maximum(1.0 - after, 0.0) * 0.1


def loop(before, moved, after, docked):
    """1 for docking, and for every step forth as much as it is wide: none is taken back for a step back."""
    return docked * 1.0 + 2.0 * np.maximum(moved, 0.0)


def hovering(before, moved, after, docked):
    """Being near, each step: docking ends that."""
    return np.maximum(after, 0.0)
