"""Ships on a line, moved by actions of any space, of which any space is observed: what a search has to get right."""

from dataclasses import dataclass

import gymnasium
import numpy as np
from gymnasium.spaces import (
    Box,
    Dict,
    Discrete,
    Graph,
    GraphInstance,
    MultiBinary,
    MultiDiscrete,
    Sequence,
    Text,
    Tuple,
)  # fmt: skip

LENGTH, DOCK = 12, 4
AT = Box(-9.0, 9.0, (1,), np.float32)
WAYS = {
    "later": (Discrete(3, start=1), lambda it: it - 2),
    "several": (MultiDiscrete([3, 2]), lambda it: it[0] - 1),
    "bits": (MultiBinary(2), lambda it: int(it[0]) - int(it[1])),
    "pair": (Tuple([Discrete(2), Discrete(2, start=5)]), lambda it: it[0] - (it[1] - 5)),
    "named": (Dict({"go": MultiDiscrete([2, 2])}), lambda it: it["go"][0] - it["go"][1]),
    "many": (MultiDiscrete([40, 40]), lambda it: np.sign(it[0] - it[1])),
    "mixed": (Dict({"on": Discrete(2), "push": Box(-1.0, 1.0, (1, 1))}), lambda it: it["on"] * float(it["push"].sum())),
    "free": (Box(-np.inf, np.inf, (1,), np.float32), lambda it: float(it[0])),
    "whole": (Box(-1, 1, (1,), np.int64), lambda it: it[0]),
}
"""Spaces of actions, and how far an action moves a ship, at most 1."""
VIEWS = {
    "number": (AT, lambda at: at),
    "text": (Text(20), lambda at: f"at {at[0]:.3g}"),
    "sequence": (Sequence(AT), lambda at: (at,) * int(abs(at[0]))),
    "graph": (Graph(AT, None), lambda at: GraphInstance(at[None], None, None)),
    "said": (Dict({"at": AT, "said": Text(20)}), lambda at: {"at": at, "said": f"at {at[0]:.3g}"}),
}
"""Spaces of observations, and what is observed of a place."""


class _Ship(gymnasium.Env):
    """It begins at 0; at the dock the episode ends."""

    def __init__(self, takes, sees):
        (self.action_space, self.moves), (self.observation_space, self.see) = WAYS[takes], VIEWS[sees]

    def reset(self, **options):
        super().reset(**options)
        self.at = 0.0
        return self._seen(), {}

    def step(self, action):
        assert self.action_space.contains(action)
        self.at += float(np.clip(self.moves(action), -1.0, 1.0))
        docked = self.at > DOCK - 0.5
        info = {"docked": docked, "hover": 1.0 * (DOCK - 1.5 < self.at < DOCK - 0.5) + docked}
        return self._seen(), float(docked), docked, False, info

    def _seen(self):
        return self.see(np.array([self.at], np.float32))


@dataclass(frozen=True)
class Ships:
    """What ships take and see; ``own`` pays for docking, ``hover`` for being near too."""

    takes: str = "later"
    sees: str = "number"

    def make(self):
        return gymnasium.wrappers.TimeLimit(_Ship(self.takes, self.sees), LENGTH)

    def rewards(self, env):
        return {"own": "own", "hover": "hover"}

    def behaviour(self, env):
        return {"success": "docked"}
