"""In which order the rows of a log stand, and which columns a log of each unit has."""

from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np

from harness.log import Rows, Unit
from harness.testing.violations import require

STEPS = ("env", "episode", "step", "terminated", "truncated")
NEEDED: Mapping[Unit, tuple[tuple[str, ...], ...]] = MappingProxyType(
    {
        "step": tuple((name,) for name in STEPS),
        "episode": (("length", "time"),),
        "point": (("time",),),
    }
)
"""By unit, the columns that a log must have; of several in one tuple, one."""
NUMBERS = {"env": "iu", "episode": "iu", "step": "iu", "start": "b", "terminated": "b", "truncated": "b"}
"""Kinds of numpy types that standard columns have: whole numbers and truth values are no floats."""


def require_order_of_steps(rows: Rows) -> None:
    """See that in each env episodes count up from 0, steps within them from 0 or 1, and ends stand at their ends."""
    for env in np.unique(rows["env"]):
        require_order_of_env(rows.part(rows["env"] == env), f"env {env}")


def require_order_of_env(rows: Rows, env: str) -> None:
    """See that the steps of one env are in order."""
    episode, step = rows["episode"].astype(int), rows["step"].astype(int)
    begins = np.concatenate([[True], np.diff(episode) != 0])
    ended = rows["terminated"] | rows["truncated"]
    require(episode[0] == 0, f"{env}: its episodes begin with {episode[0]}, not 0")
    require(np.isin(np.diff(episode), (0, 1)).all(), f"{env}: its episodes do not count up by one: {episode[:20]}")
    require(np.isin(step[begins], (0, 1)).all(), f"{env}: the steps of an episode begin with {step[begins][:9]}")
    require((np.diff(step)[~begins[1:]] == 1).all(), f"{env}: its steps do not count up by one: {step[:20]}")
    inner = np.flatnonzero(ended[:-1] & ~begins[1:])
    require(not len(inner), f"{env}: an episode goes on after a row that ended it")
    without = np.flatnonzero(begins[1:] & ~ended[:-1])
    told = "is ended by neither terminated nor truncated, and another begins"
    require(not len(without), "{}: episode {} {}", env, episode[without[:1]], told)
    if "start" in rows.columns:
        require(not (rows["start"] & (step != 0)).any(), f"{env}: a row is a start and has a step that is not 0")


def broken_types(rows: Rows) -> Iterator[str]:
    """A sentence for each column whose values are not what its name says."""
    for name, values in rows.columns.items():
        wanted = NUMBERS.get(name, "")
        if wanted and values.dtype.kind not in wanted:
            yield f"the column {name} holds {values.dtype}, not {'truth values' if wanted == 'b' else 'whole numbers'}"
        if values.dtype.kind == "O":
            yield f"the column {name} holds Python objects, not numbers"
        if name.startswith(("reward/", "behaviour/")) and (values.ndim != 1 or values.dtype.kind not in "biuf"):
            yield f"the column {name} holds {values.dtype} of shape {values.shape}, not one number a row"
