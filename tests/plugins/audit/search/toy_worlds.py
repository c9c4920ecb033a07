"""Small worlds of which everything is known: any Gymnasium environment behind the protocol `World`, with one reward."""

import gymnasium
import numpy as np
from gymnasium.spaces import Discrete
from numpy.random import default_rng

from harness_plugins.audit.search.world import Outcomes, Shown


class EnvWorld:
    """An environment paid by a function, or by itself.

    `succeeds` says of (observation, paid, terminated, info) whether a step is a success; `pays` of (before, action,
    after, paid, terminated) what it pays.
    """

    def __init__(self, make, succeeds, pays=None, gamma=0.99, horizon=None):
        self.env = make()
        self.name, self.reward, self.gamma, self.success = "toy", "own", gamma, "success"
        self.succeeds, self.pays = succeeds, pays
        self.horizon = horizon or self.env.spec.max_episode_steps
        self.space, self.observes = self.env.action_space, self.env.observation_space
        self.is_repeated, self.taken = True, 0
        self.directions, self.notes, self.together = {}, (), 1

    def watch(self, start, policy):
        observed, _ = self.env.reset(seed=int(start))
        seen, paid, success, actions, ended = [observed], [], [], [], "cut"
        while len(actions) < self.horizon:
            action = policy(observed)
            after, pay, terminated, truncated, info = self.env.step(action)
            if self.pays:
                pay = self.pays(observed, action, after, pay, terminated)
            self.taken += 1
            actions.append(action)
            seen.append(after)
            paid.append(pay)
            success.append(self.succeeds(after, pay, terminated, info))
            observed = after
            if terminated or truncated:
                ended = "terminated" if terminated else "truncated"
                break
        return Shown(
            start, np.array(actions), np.array(paid, float), {}, np.array(success, bool), {}, ended, tuple(seen)
        )

    def show(self, start, actions):
        rest = iter(actions)
        return self.watch(start, lambda observed: next(rest))

    def outcomes(self, shown):
        paid = np.array([it.paid.sum() for it in shown])
        discounted = np.array([(it.paid * self.gamma ** np.arange(len(it.paid))).sum() for it in shown])
        success = np.array([it.success[-1] for it in shown])
        time = [int(it[-1]) + 2 if len(it) else 1 for it in [np.flatnonzero(~it.success) for it in shown]]
        return Outcomes(
            steps=np.array([len(it.paid) for it in shown]),
            paid=paid,
            discounted=discounted,
            success=success,
            time=np.where(success, time, self.horizon),
            share=np.array([it.success.mean() for it in shown]),
            near=np.full(len(shown), np.nan),
        )

    def play(self, starts, actions):
        return self.outcomes([self.show(start, taken) for start, taken in zip(starts, actions, strict=True)])

    def act(self, starts, policy):
        shown = [self.watch(start, policy) for start in starts]
        return self.outcomes(shown), [it.actions for it in shown]

    def close(self):
        self.env.close()


class Graph(gymnasium.Env):
    """A graph: by state and action, what comes of it (state, pay, success, end)."""

    def __init__(self, edges, begin=0):
        self.edges, self.begin = edges, begin
        self.observation_space = Discrete(len(edges))
        self.action_space = Discrete(len(edges[0]))

    def reset(self, **options):
        super().reset(**options)
        self.at = self.begin
        return self.at, {}

    def step(self, action):
        self.at, pay, success, end = self.edges[self.at][int(action)]
        return self.at, pay, end, False, {"success": success}


def told(observation, paid, terminated, info):
    """Success as the info says it."""
    return info["success"]


def random_graph(seed, states=5, actions=2, lasting=False):
    """A graph drawn at random; success ends nothing if it is `lasting`."""
    rng = default_rng(seed)
    edges = []
    for _ in range(states):
        row = []
        for _ in range(actions):
            success, end = bool(rng.random() < 0.3), bool(rng.random() < 0.2)
            row.append(
                (int(rng.integers(states)), float(rng.integers(-3, 4)), success, end or (success and not lasting))
            )
        edges.append(row)
    return edges
