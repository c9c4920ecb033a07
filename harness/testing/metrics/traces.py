"""What the metric checks hand to a metric."""

from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.log import Log
from harness.record.episode_facts import EpisodeFacts
from harness.record.trace import FLAGS, INTEGERS, NUMBERS, OBSTACLE, QVEL, trace_of

REWARDS = ("reward", "reward_ground", "reward_target", "reward_step")
DOF = 2
HORIZON = 9
"""The steps of short episodes, which are enough for most checks."""
FACTS = EpisodeFacts(horizon=HORIZON, control_period=0.1, ik_steps=(3,), work=(2.5,))
"""The facts of the one env that there is."""


def recorded_trace(seed: int, ends: tuple[str, ...], horizon: int = HORIZON) -> Log:
    """One env's episodes, one per item of `ends`.

    ``ground``, ``obstacle``, ``reached``, ``truncated``; ``touched``: the target was reached on the way, the horizon at
    the end; or ``""``: left unfinished. The numbers are random. After its start row an episode has 3 to `horizon`
    steps.
    """
    rng = np.random.default_rng(seed)
    parts = [_episode(rng, number, end, horizon) for number, end in enumerate(ends)]
    columns = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]} if parts else _rows(rng, 0)
    return trace_of(columns, replace(FACTS, horizon=horizon))


def _episode(rng: np.random.Generator, number: int, end: str, horizon: int) -> dict[str, NDArray[Any]]:
    columns = _rows(rng, int(rng.integers(4, horizon + 1)))
    columns["episode"][:] = number
    columns["step"][:] = np.arange(len(columns["step"]))
    if end == "touched":
        columns["reached"][2], columns["truncated"][-1] = True, True
    elif end:
        columns[end][-1] = True
        columns["terminated"][-1] = end != "truncated"
    return columns


def _rows(rng: np.random.Generator, rows: int) -> dict[str, NDArray[Any]]:
    columns: dict[str, NDArray[Any]] = {name: np.zeros(rows, np.int32) for name in INTEGERS}
    columns.update({name: rng.uniform(0.0, 1.0, rows) for name in NUMBERS})
    columns.update({name: np.zeros(rows, bool) for name in (*FLAGS, OBSTACLE)})
    columns.update({name: rng.uniform(-1.0, 1.0, (rows, DOF)) for name in ("qpos", "action")})
    columns[QVEL] = np.gradient(columns["qpos"], axis=0) if rows > 1 else np.zeros((rows, DOF))
    return columns
