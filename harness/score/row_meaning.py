"""What a row of somebody's table stands for: a step, as an index needs it, or an episode or a mean over many."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc

from harness.arrays import Float, Ints
from harness.errors import SchemaError, UsageError
from harness.log.text_table import NOTHING, TextTable
from harness.text import shortened

NEEDED = "an index needs the reward of each environment step"
RECORD = "harness.RecordRewards records it"

EPISODE = ("episode", "ep", "eps", "episode_id", "episode_index", "episode_number", "episode_num", "i_episode")
LENGTH = (
    "l", "length", "len", "episode_length", "ep_length", "ep_len", "eplen", "episode_len", "episode_steps", "ep_steps",
    "num_steps", "n_steps", "steps", "timesteps",
)  # fmt: skip
COUNTER = (
    "t", "step", "timestep", "time_step", "step_count", "env_step", "environment_step", "global_step", "total_steps",
    "total_timesteps", "", "index", "unnamed: 0",
)  # fmt: skip
ACROSS_EPISODES = ("global_step", "total_steps", "total_timesteps")
"""Counters that no new episode sets back."""
INDEX = ("", "index", "unnamed: 0")
"""Counters of rows, as pandas writes them: they say nothing of steps."""
ENV = "env"
"""Which of several envs a row is of."""
SEED = ("seed", "random_seed", "rng_seed")
RUN = ("run", "run_id", "run_name", "run_number", "trial", "trial_id", "experiment", "exp_name", *SEED)
"""Which of several runs a row is of. A seed may also be that of an episode."""
OF_STEPS = tuple(name for name in COUNTER if name not in (*INDEX, *ACROSS_EPISODES))
BEGIN_OF_STEPS = ("obs", "action", "state", "done", "terminat", "truncat")
"""Names of columns, and beginnings of names, that tables of steps have."""
MOST_RUNS = 10_000
OF_MANY = re.compile(r"iteration|epoch|update|mean|average|success_?rate")
"""In names of columns that tables of curves have."""
TRUTHS = ("success", "is_success")
"""Columns that are 0 or 1 in a step, and in tables of curves a share of episodes."""
MOST_WORDS = 50
NO_WORDS = ("nan", "none", "null", "true", "false", "inf", "infinity")
SAYS_NOTHING = re.compile(r"time|date|host|node|ip$|uuid|_id$|_tag$|version|path|file|dir|device|url")
"""In names of columns whose words say nothing of a training."""


ROLES = {"episode": EPISODE, "length": LENGTH, "counter": COUNTER, "env": (ENV,), "run": RUN}


def roles_in(names: Sequence[str]) -> dict[str, str]:
    """The columns that say what rows are, by what they are for, the first of each.

    Args:
        names: Of all columns, as in the header.
    """
    spelled = {name.strip().lower(): name for name in reversed(names)}
    return {role: spelled[it] for role, of in ROLES.items() for it in reversed(of) if it in spelled}


class Fault(NamedTuple):
    """A row that is no episode after the one before it."""

    row: int
    why: str
    is_steps: bool = True
    """Whether the rows may be steps, so that a format of steps has to read the table."""


def why_no_steps(table: TextTable) -> str:
    """The column by which rows, or the first ones, are episodes or means over some; empty of steps."""
    roles = roles_in(table.names)
    lower = {name.lower(): name for name in table.names}
    if not table.lines or any(
        (it in OF_STEPS and _is_whole(table, lower[it])) or it.startswith(BEGIN_OF_STEPS) for it in lower
    ):
        return ""
    share = next((lower[it] for it in TRUTHS if it in lower and not _is_whole(table, lower[it])), "")
    by_name = next((name for it, name in lower.items() if OF_MANY.search(it)), share)
    found = by_name or roles.get("length") or roles.get("episode", "")
    if by_name or not found:
        return by_name
    with suppress(SchemaError):  # what is called by letters is no episode that was counted
        if "length" in roles and (table.numbers(roles["length"]) <= 1.0).all():
            return ""  # an episode of one step is a step
        runs = [name for name in table.names if names_a_run(name) and not is_of_episodes(table, name)]
        groups = split(table, [*runs, *labels_of(table, [name for name in table.names if name not in runs])])
        faults = [fault_of_episodes(table, roles, rows) for _, rows in groups]
        return "" if any(fault and fault.is_steps for fault in faults) else found
    return ""


def _is_whole(table: TextTable, name: str) -> bool:
    """Whether a column holds whole numbers, as a count does, or nothing."""
    try:
        values = table.numbers(name, NOTHING)
    except SchemaError:
        return True
    return bool((np.isnan(values) | (values == np.floor(values))).all())


def names_a_run(name: str) -> bool:
    """Whether a column of this name says of which training a row is."""
    return name.lower() in (*RUN, "name")


def is_of_episodes(table: TextTable, name: str) -> bool:
    """Whether a column is the seed of each episode, another one in each row."""
    return name.lower() in SEED and len({*table.cells[name]}) == len(table) > 1


def labels_of(table: TextTable, names: Iterable[str]) -> list[str]:
    """Those of some columns in which one of few words stands in every row, and not the same in all."""
    words = {name: {cell.strip() for cell in table.cells[name]} for name in names}
    return [
        name
        for name, of in words.items()
        if 1 < len(of) < min(len(table), MOST_WORDS + 1)
        and all(word[:1].isalpha() and word.lower() not in NO_WORDS for word in of)
        and not SAYS_NOTHING.search(name.lower())
    ]


def split(table: TextTable, names: Sequence[str]) -> list[tuple[tuple[str, ...], Ints]]:
    """What stands in some columns, in the order in which it first does, and the numbers of the rows in which it does.

    Raises:
        SchemaError: There is too much of it.
    """
    if not names:
        return [((), np.arange(len(table)))]
    found = defaultdict[tuple[str, ...], list[int]](list)
    for row, cells in enumerate(zip(*(table.cells[name] for name in names), strict=True)):
        found[tuple(map(str.strip, cells))].append(row)
    if len(found) > MOST_RUNS:
        raise SchemaError(f"{table.path}: '{', '.join(names)}' names more than {MOST_RUNS:,} runs")
    return [(cells, np.array(rows)) for cells, rows in found.items()]


def fault_of_episodes(table: TextTable, roles: Mapping[str, str], rows: Ints) -> Fault | None:
    """The first of these rows, of one run, that is no episode after the one before it; None if all are.

    Raises:
        SchemaError: Its numbers of episodes, or its lengths, are no numbers.
    """
    if "episode" in roles:
        envs = [table.cells[roles["env"]][row] for row in rows] if "env" in roles else [""] * len(rows)
        last: dict[str, float] = {}
        for row, number, env in zip(rows, table.numbers(roles["episode"])[rows], envs, strict=True):
            if number == last.get(env):
                return Fault(int(row), f"episode {number:g} stands twice: a row is a step, or there are several runs")
            if number < last.get(env, -np.inf):
                return Fault(int(row), f"it goes back to episode {number:g}: the file holds several runs", False)
            last[env] = number
        return None
    lengths = table.numbers(roles["length"])[rows] if "length" in roles else np.empty(0)
    counts_up = (np.diff(lengths) == 1.0) | (lengths[1:] <= 1.0)
    if len(lengths) > 2 and lengths[0] <= 1.0 and counts_up.all():
        return Fault(int(rows[1]), f"column '{roles['length']}' counts up from row to row: a row is a step")
    return None


class RowWatch:
    """Looks at all rows of a table of steps, some at a time: whether they count up, and are of one run."""

    def __init__(self, path: Path, columns: Mapping[str, str]) -> None:
        self._path, self._columns = path, {role: name.strip().lower() for role, name in columns.items()}
        self._run, self._episode = "", np.nan
        self._count_of_env: dict[float, float] = {}

    def look(self, cells: Mapping[str, pa.Array], line: int) -> None:
        """Look at the next rows, of which there is one.

        Args:
            cells: By role what stands in its column, as text or as numbers.
            line: Of the first row.

        Raises:
            UsageError: They are no single steps; names the line, and what to do.
        """
        counts, env, episodes = (self._numbers(role, cells) for role in ("counter", "env", "episode"))
        runs = [(name or "").strip() for name in cells["run"].to_pylist()] if "run" in cells else []
        of_env = np.zeros(1) if env is None else np.nan_to_num(env)
        for row, why in chain(self._other_runs(runs, episodes), self._jumps(counts, of_env)):
            raise UsageError(f"{self._path}: line {line + row}: {why}")

    def _numbers(self, role: str, cells: Mapping[str, pa.Array]) -> Float | None:
        """Whole numbers, NaN where a cell is empty; None, for good, of a column that holds anything else."""
        if role not in self._columns:
            return None
        column, values = cells[role], np.array([0.5])
        with suppress(pa.ArrowException, ValueError):
            if pa.types.is_string(column.type):
                column = pc.utf8_trim_whitespace(column).cast(pa.float64())
            values = column.to_numpy(zero_copy_only=False).astype(np.float64)
        if np.isnan(values).all() or (values != np.floor(values))[~np.isnan(values)].any():
            del self._columns[role]
            return None
        return values

    def _jumps(self, counts: Float | None, env: Float) -> Iterator[tuple[np.intp, str]]:
        """Rows that are not the next step of their env, and why."""
        if counts is None:
            return
        name = self._columns["counter"]
        before = np.empty(len(counts))  # what it was in the row before of the same env
        for number in np.unique(env).tolist():
            rows = np.flatnonzero(np.broadcast_to(env, before.shape) == number)
            before[rows] = [self._count_of_env.get(number, np.nan), *counts[rows[:-1]]]
            self._count_of_env[number] = counts[rows[-1]]
        rise = counts - before
        again = (counts <= 1.0) & (rise <= 0.0) & (name not in ACROSS_EPISODES)
        for row in np.flatnonzero(np.isfinite(rise) & (rise != 1.0) & ~again):
            if rise[row] > 1.0:
                why = "rows are missing, or a row is more than a step"
            elif rise[row] == 0.0:
                why = f"a row stands twice, or several envs stand in one file; a column '{ENV}' says which"
            else:
                why = "rows stand in another order, or the file holds two runs"
            yield (
                row,
                f"column '{name or 'without a name'}' goes from {before[row]:,.0f} to {counts[row]:,.0f}: {why}, and "
                f"{NEEDED}. If each row is a step, delete that column",
            )

    def _other_runs(self, runs: list[str], episodes: Float | None) -> Iterator[tuple[np.intp, str]]:
        """Rows that are of another run than the row before; the seed of an episode changes where the next begins."""
        if not runs:
            return
        column, before = self._columns["run"], [self._run or runs[0], *runs[:-1]]
        changes, self._run = np.array(runs) != np.array(before), runs[-1]
        if column in SEED and episodes is not None:
            changes &= np.diff(episodes, prepend=self._episode) != 1.0
            self._episode = episodes[-1]
        for row in np.flatnonzero(changes):
            yield (
                row,
                f"column '{column}' goes from {shortened(before[row], 40)} to {shortened(runs[row], 40)}: the file "
                "holds several runs. Give each run a file of its own. If all rows are one run, delete that column",
            )
