"""Comparisons with the values of seeds, made by hand."""

import numpy as np

from harness.eta import Quantity, change_of, swaps_of
from harness.registry import Choice
from harness.results import Comparison, Group
from harness.results.comparison import Behaviour

SUCCESS = Quantity("success_rate", "", "higher", "deterministic", 100)
TIME = Quantity("time_to_target", "s", "lower", "deterministic", bounds=(0.0, 5.0))
SPEED = Quantity("success_rate", "", "higher", "while training", 100)


def comparison(
    proposed,
    values,
    place="mujoco",
    baseline="baseline",
    speed=None,
    first_seed=0,
    steps=1000,
    **fields,
):
    """A comparison in one place.

    Args:
        proposed: The reward.
        values: By measure, (2, seeds): under the baseline and under the proposed reward.
        place: The simulator.
        baseline: The other reward.
        speed: Success over the training, (2, seeds).
        first_seed: Seeds count from here.
        steps: Of each training.
        fields: Others of the comparison.
    """
    seeds = tuple(range(first_seed, first_seed + next(iter(values.values())).shape[1]))
    given = [({"success_rate": SUCCESS, "time_to_target": TIME}[name], it) for name, it in values.items()]
    given += [] if speed is None else [(SPEED, speed)]
    group = Group(
        "fd100", Choice("reach", (), "reach"), Choice("sac", (), "sac"), steps, 100,
        simulator=Choice(place, (), place),
    )  # fmt: skip
    return Comparison(
        group,
        baseline,
        proposed,
        seeds,
        trained=(seeds, seeds),
        measured=Behaviour(tuple(change(measure, it, seeds) for measure, it in given), episodes={"deterministic": 100}),
        **fields,
    )


def rates(mean, other, seeds=20, spread=0.05, seed=0):
    """Success under the baseline and under the proposed reward, (2, seeds)."""
    values = np.random.default_rng(seed).normal(size=(2, seeds)) * spread + np.array([[mean], [other]])
    return np.clip(values, 0.0, 1.0)


def change(measure, values, seeds):
    """Of the values of the seeds under both rewards, (2, seeds)."""
    one, other = (dict(zip(seeds, map(float, side), strict=False)) for side in values)
    return change_of(measure, one, other, swaps_of(seeds))
