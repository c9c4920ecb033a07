"""In which order the rows of a log stand, and which columns a log of each unit has."""

from collections.abc import Iterator, Mapping
from types import MappingProxyType

import numpy as np

from harness.log import Rows, Unit
from harness.testing.violations import require

NEEDED: Mapping[Unit, tuple[tuple[str, ...], ...]] = MappingProxyType(
    {
        "step": (("episode",), ("step",)),
        "episode": (("length", "time"),),
        "point": (("time", "iteration"),),
    }
)
"""By unit, the columns that a log must have; of several in one tuple, one."""
NUMBERS = {"env": "iu", "episode": "iu", "step": "iu", "start": "b", "terminated": "b", "truncated": "b"}
"""Kinds of numpy types that standard columns have: whole numbers and truth values are no floats."""


def require_order_of_steps(rows: Rows) -> None:
    """See that in each env episodes count up from 0, steps within them from 0 or 1, and ends stand at their ends."""
    envs = rows.columns.get("env", np.zeros(len(rows), int))
    for env in np.unique(envs):
        of_env = rows.part(envs == env)
        require_counts(of_env, f"env {env}")
        require_ends(of_env, f"env {env}")


def require_counts(rows: Rows, env: str) -> None:
    """See that episodes and steps of one env count up."""
    episode, step = rows["episode"].astype(int), rows["step"].astype(int)
    begins = np.concatenate([[True], np.diff(episode) != 0])
    require(episode[0] == 0, f"{env}: its episodes begin with {episode[0]}, not 0")
    require(np.isin(np.diff(episode), (0, 1)).all(), f"{env}: its episodes do not count up by one: {episode[:20]}")
    require(np.isin(step[begins], (0, 1)).all(), f"{env}: the steps of an episode begin with {step[begins][:9]}")
    require((np.diff(step)[~begins[1:]] == 1).all(), f"{env}: its steps do not count up by one: {step[:20]}")
    if "start" in rows.columns:
        require(not (rows["start"] & (step != 0)).any(), f"{env}: a row is a start and has a step that is not 0")


def require_ends(rows: Rows, env: str) -> None:
    """See that episodes of one env end where it is said; of a log with both ends, that it is said where they end."""
    told = [rows[name].astype(bool) for name in ("terminated", "truncated") if name in rows.columns]
    if not told:
        return
    ended, goes_on = np.any(told, axis=0)[:-1], np.diff(rows["episode"].astype(int)) == 0
    require(not (ended & goes_on).any(), f"{env}: an episode goes on after a row that ended it")
    without = rows["episode"][:-1][~ended & ~goes_on]
    if len(told) == 2:
        why = "is ended by neither terminated nor truncated, and another begins"
        require(not len(without), "{}: episode {} {}", env, without[:1], why)


def broken_types(rows: Rows) -> Iterator[str]:
    """A sentence for each column whose values are not what its name says."""
    for name, values in rows.columns.items():
        wanted = NUMBERS.get(name, "")
        if wanted and values.dtype.kind not in wanted:
            yield f"the column {name} holds {values.dtype}, not {'truth values' if wanted == 'b' else 'whole numbers'}"
        if values.dtype.kind == "O" and not all(isinstance(value, str) for value in values.flat):
            yield f"the column {name} holds Python objects, neither numbers nor texts"
        if name.startswith(("reward/", "behaviour/")) and (values.ndim != 1 or values.dtype.kind not in "biuf"):
            yield f"the column {name} holds {values.dtype} of shape {values.shape}, not one number a row"
