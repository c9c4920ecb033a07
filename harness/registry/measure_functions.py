"""Makes a `harness.log.Measure` of a plain function of a step or of an episode that a user wrote.

::

    lower_is_better = ["calm", "path_length"]
    units = {"path_length": "m"}

    def calm(step):
        return np.abs(step.action).max(-1)

    def path_length(episode):
        return np.linalg.norm(episode.end_effector - episode.before.end_effector, axis=-1).sum()

What ``calm`` says of the last step of an episode is its value for the episode. ``path_length`` is given all steps of an
episode. The measure is the mean over the finished episodes. A function that says true or false is a share of them.
"""

import dataclasses
import sys
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from harness.errors import Unmeasured, UsageError
from harness.eta.interval import SHARE, UNBOUNDED, Bounds, are_bounds
from harness.eta.laws import Better, direction_of
from harness.reward.forms import STEP, takes_alone
from harness.reward.row_steps import has_field, steps_of_run
from harness.reward.steps import ARM, BEFORE, MissingField, Steps, rows_of
from harness.reward.terms import ROWS, Noting, of_made_up

EPISODE = "episode"
"""What the one argument of a function of episodes is called."""
SUCCESS = "success"
"""The measure that decides, if a user gives one of this name; it is a share."""
LOWER, HIGHER, BOUNDS, UNITS = "lower_is_better", "higher_is_better", "bounds", "units"
"""Names in a file of measures: lists of those of which less and of which more is better; by name of a measure what a
value can be, and its unit."""
FIELDS = tuple(field.name for field in ARM)
MADE_UP_STEPS = 16


class Said(NamedTuple):
    """What a file says of one of its measures."""

    unit: str = ""
    better: Better = ""
    bounds: Bounds = UNBOUNDED


def is_function_of_episodes(found: Any) -> bool:
    """Whether something is a plain function whose one argument without a default is called ``episode``."""
    return takes_alone(found, EPISODE)


def is_measure_function(found: Any) -> bool:
    """Whether something is a plain function of a step or of an episode."""
    return takes_alone(found, STEP) or takes_alone(found, EPISODE)


def said_of(
    module: Any, names: Iterable[str], *, flags: Collection[str] = (), all_of_it: bool = True
) -> dict[str, Said]:
    """What a file says of its measures.

    Args:
        module: The file, imported.
        names: Its measures.
        flags: Those of them that say true or false.
        all_of_it: Whether `BOUNDS` and `UNITS` count. Files for environments alone may hold anything there.

    Raises:
        UsageError: It says something of another name, or what cannot be said.
    """
    known = list(names)
    lower, higher = ({it} if isinstance(it := getattr(module, what, ()), str) else {*it} for what in (LOWER, HIGHER))
    bounds, units = ((_by_name(module, what) if all_of_it else {}) for what in (BOUNDS, UNITS))
    for what, named in ((LOWER, lower), (HIGHER, higher), (BOUNDS, bounds), (UNITS, units)):
        for name in named:
            if name not in known:
                raise UsageError(f"{what} names {name!r}, which is none of {', '.join(known)}")
    for name, ends in bounds.items():
        if not are_bounds(ends):
            raise UsageError(f"{BOUNDS}[{name!r}] is {ends!r}: write two numbers, the lower one first")
    return {
        name: Said(
            str(units.get(name, "")),
            direction_of(name, lower, higher, is_flag=name in flags),
            tuple(bounds.get(name, UNBOUNDED)),
        )
        for name in known
    }


def _by_name(module: Any, what: str) -> dict[str, Any]:
    given = getattr(module, what, {})
    if not isinstance(given, Mapping):
        raise UsageError(f"{what} is {given!r}: write a dict by name of a measure, {what} = {{'NAME': ...}}")
    return dict(given)


@cache
def measure_class(function: Callable[[Steps], Any]) -> type[Any]:
    """A frozen dataclass without parameters that is the measure of a function of a step or of an episode.

    Args:
        function: It is called once, on made-up steps, to learn what it reads, and whether it says true or false.

    Raises:
        UsageError: It fails, reads what a step of an arm does not have, or returns something else than it has to.
    """
    name, module = function.__name__, sys.modules[function.__module__]
    of_episode = is_function_of_episodes(function)
    try:
        needs, is_flag = of_made_up(partial(_tried, function, of_episode))
        said = said_of(module, vars(module), flags=[name] if is_flag or name == SUCCESS else ())[name]
    except UsageError as error:
        raise UsageError(f"Measure '{name}': {error}") from error
    is_share = is_flag or said.bounds == SHARE or (name == SUCCESS and said.bounds == UNBOUNDED)
    bounds = SHARE if is_share else said.bounds
    measured = _measure_episodes if of_episode else _measure_ends

    def call(self: Any, trace: Any) -> float | None:
        if not len(trace.last_rows):
            return None
        values = _on(trace, needs, partial(measured, function))
        for value in values:
            if not bounds[0] <= value <= bounds[1]:
                raise Unmeasured(
                    f"it is {value:g} in an episode: it has to lie between {bounds[0]:g} and {bounds[1]:g}"
                )
        return float(np.mean(values)) if len(values) else None

    call.__doc__ = "The mean over finished episodes; None without one."
    members = {
        "__doc__": function.__doc__,
        "__call__": call,
        "unit": said.unit,
        "better": said.better,
        "bounds": bounds,
        "is_share": is_share,
        "needs": needs,
    }
    made = dataclasses.make_dataclass(name, [], frozen=True, namespace=members)
    made.__module__, made.__qualname__ = function.__module__, function.__qualname__
    return made


class _Fields(Noting):
    """Steps that are asked for their fields alone: what counts their rows or goes through them is a mistake."""

    def __len__(self) -> int:
        raise UsageError("len() of steps counts their fields: len(episode.step) is that of an episode's steps")

    def __iter__(self) -> Iterator[Any]:
        raise UsageError("steps are arrays, one for each field, and not a list: read episode.distance, episode.action")

    def __getitem__(self, index: Any) -> Any:
        raise UsageError(f"steps have no [{index!r}]: read a row of a field, episode.distance[{index!r}]")


def _tried(function: Callable[..., Any], of_episode: bool, steps: Steps) -> tuple[frozenset[str], bool]:
    """What a function reads of made-up steps, and whether it says true or false."""
    noted: set[str] = set()
    rows = np.arange(MADE_UP_STEPS if of_episode else ROWS) % ROWS
    with np.errstate(all="ignore"):
        answer = function(_Fields(rows_of(steps, rows), noted))
    if of_episode:
        return frozenset(noted), answer is not None and as_numbers(answer, (), "an episode").dtype.kind == "b"
    return frozenset(noted), as_numbers(answer, (ROWS,), f"{ROWS} steps").dtype.kind == "b"


def _on(trace: Any, needs: Iterable[str], measured: Callable[[Any, Steps], NDArray[Any]]) -> NDArray[Any]:
    """What a function says of the finished episodes of a trace.

    Raises:
        Unmeasured: The trace does not have what it reads.
    """
    read = {name.removeprefix(f"{BEFORE}.") for name in needs}
    missing = [name for name in FIELDS if name in read and not has_field(trace, name)]
    if missing:
        raise Unmeasured(
            f"it reads {', '.join(missing)}, which was not recorded. Trainings with this measure record it"
        )
    try:
        return measured(trace, steps_of_run(trace, read))
    except MissingField:  # it reads one in some steps alone, and not in made-up ones
        return measured(trace, steps_of_run(trace, FIELDS))


def _measure_ends(function: Callable[..., Any], trace: Any, steps: Steps) -> NDArray[Any]:
    """What a function of a step says of the last step of each finished episode."""
    ends = trace.last_rows
    return as_numbers(function(rows_of(steps, ends)), ends.shape, f"{len(ends):,} steps").astype(np.float64)


def _measure_episodes(function: Callable[..., Any], trace: Any, steps: Steps) -> NDArray[Any]:
    """What a function of an episode says of each finished one; those of which it says None are left out."""
    told = []
    for rows in trace.episodes:
        own = rows[trace["step"][rows] > 0]
        answer = function(rows_of(steps, own))
        if answer is not None:
            told.append(float(as_numbers(answer, (), f"an episode of {len(own):,} steps")))
    return np.array(told)


def as_numbers(answer: Any, shape: tuple[int, ...], of: str) -> NDArray[Any]:
    """What a function returned, as an array.

    Raises:
        UsageError: It is of another shape, no number, or not finite.
    """
    found = np.asarray(answer)
    if found.dtype.kind not in "biuf":
        raise UsageError(f"it returned {answer!r} for {of}, which is no number")
    if found.shape != shape:
        told = f"an array of shape {found.shape}" if found.shape else "one number"
        wanted = f"one number for each, shape {shape}, as by .sum(-1)" if shape else "one number"
        raise UsageError(f"it returned {told} for {of}: return {wanted}")
    if not np.isfinite(found).all():
        raise UsageError(f"it returned {found[~np.isfinite(found)][0] if shape else found} for {of}")
    return found
