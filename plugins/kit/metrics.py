"""What a metric must satisfy. Each check takes the metric."""

import copy
import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from harness.log import Log, Measure
from harness.record import EpisodeFacts, trace_of
from harness.record.trace import FLAGS, INTEGERS, NOTHING_KNOWN, NUMBERS, OBSTACLE, QVEL, with_episode_facts

from .contract import check, require, settings_are_frozen, settings_survive_json

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


LONG_HORIZON = 100
"""Steps, as in the default task, ``fd100-reach``."""
ALL_ENDS = ("reached", "ground", "truncated", "touched", "reached", "truncated")
SOME_ENDS: tuple[tuple[str, ...], ...] = (
    ALL_ENDS,
    ("reached",),
    ("ground",),
    ("truncated",),
    ("touched",),
    ("",),
    ("", "ground"),
)


@check("metric-unit")
def unit_and_better_are_declared(metric: Measure) -> None:
    """`unit` is a text, empty where there is none; `better` is ``higher``, ``lower``, or empty where nobody says it."""
    require(isinstance(metric.unit, str), f"unit is {metric.unit!r}, not a text")
    require(metric.better in ("higher", "lower", ""), f"better is {metric.better!r}, neither 'higher' nor 'lower'")


@check("metric-finite")
def the_value_is_finite_or_none(metric: Measure) -> None:
    """The value is a finite float, or None where it is not defined, however episodes ended, short ones and long ones.

    Also where the trace tells no facts of its episodes: one of an earlier version, or of another kind.
    """
    traces = [(ends, recorded_trace(0, ends)) for ends in SOME_ENDS]
    traces.append((ALL_ENDS, recorded_trace(0, ALL_ENDS * 10, LONG_HORIZON)))
    bare = [(ends, with_episode_facts(trace, NOTHING_KNOWN)) for ends, trace in traces]
    for ends, trace in traces + bare:
        value = metric(trace)
        require(value is None or isinstance(value, float), f"the value is a {type(value).__name__}, not a float")
        told = f"the value is {value} for a trace of {len(trace):,} rows, whose episodes ended {ends}"
        require(value is None or math.isfinite(value), told)


@check("metric-empty")
def an_empty_trace_has_no_value(metric: Measure) -> None:
    """The value of a trace without rows is None."""
    value = metric(recorded_trace(0, ()))
    require(value is None, f"the value of an empty trace is {value}, not None")


@check("metric-defined")
def a_full_trace_has_a_value(metric: Measure) -> None:
    """A trace with episodes that ended on the target, on the ground and at the horizon has a value."""
    require(metric(recorded_trace(0, ALL_ENDS)) is not None, "the value is None, however the episodes ended")


@check("metric-no-reward")
def rewards_do_not_matter(metric: Measure) -> None:
    """The value does not depend on the columns of rewards: a metric judges behaviour, not its pay."""
    trace = recorded_trace(0, ALL_ENDS)
    others = {name: recorded_trace(1, ALL_ENDS * 9)[name][: len(trace)] for name in REWARDS}
    value, scrambled = metric(trace), metric(trace.add(others))
    require(value == scrambled, f"the value goes from {value} to {scrambled} with other rewards")


@check("metric-unfinished")
def unfinished_episodes_do_not_count(metric: Measure) -> None:
    """An episode that the end of the trace cuts off changes nothing."""
    value, longer = (metric(recorded_trace(0, ends)) for ends in (ALL_ENDS, (*ALL_ENDS, "")))
    require(value == longer, f"the value goes from {value} to {longer} with an unfinished episode")


@check("metric-traces")
def traces_do_not_depend_on_one_another(metric: Measure) -> None:
    """A trace has the same value whatever was measured before."""
    value = metric(recorded_trace(0, ALL_ENDS))
    metric(recorded_trace(1, ALL_ENDS))
    again = metric(recorded_trace(0, ALL_ENDS))
    require(value == again, f"the value of the same trace goes from {value} to {again}")


@check("metric-arguments")
def the_trace_is_left_alone(metric: Measure) -> None:
    """No column is changed: the next metric reads the same trace."""
    trace = recorded_trace(0, ALL_ENDS)
    before = copy.deepcopy(dict(trace.rows().columns))
    metric(trace)
    for name, column in before.items():
        require(np.array_equal(column, trace[name]), f"the column {name} was changed")


METRIC_CHECKS = (
    settings_are_frozen,
    settings_survive_json,
    unit_and_better_are_declared,
    the_value_is_finite_or_none,
    an_empty_trace_has_no_value,
    a_full_trace_has_a_value,
    rewards_do_not_matter,
    unfinished_episodes_do_not_count,
    traces_do_not_depend_on_one_another,
    the_trace_is_left_alone,
)
