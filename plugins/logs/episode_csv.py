"""Tables that somebody's own script wrote, a row for each episode: ``episode,reward,length``, and names like these."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.arrays import Float, Ints
from harness.errors import SchemaError, UsageError
from harness.log import Log, LogFacts, in_memory
from harness.log.log import BEHAVIOUR, RECORDED, REWARD, SUCCESS
from harness.log.text_table import TextTable, first_line, parse_table, read_table, require_columns
from harness.score.row_meaning import (
    ACROSS_EPISODES,
    ENV,
    EPISODE,
    LENGTH,
    RUN,
    SEED,
    are_episodes,
    fault_of_episodes,
    runs_in,
)
from harness.text import shortened

RETURNS = (
    "return", "returns", "episode_return", "ep_return", "ep_ret", "episodic_return", "reward", "rewards",
    "episode_reward", "ep_reward", "ep_rew", "episodic_reward", "total_reward", "sum_reward", "cumulative_reward",
    "score",
)  # fmt: skip
ROLES: Mapping[str, Sequence[str]] = {
    "reward": RETURNS,
    "length": LENGTH,
    "success": ("success", "is_success", "succeeded", "successful", "reached", "goal_reached", "solved"),
    "episode": EPISODE,
    "time": (*ACROSS_EPISODES, "env_steps", "environment_steps", "timesteps_total", "cumulative_steps"),
    "env": (ENV,),
    "run": RUN,
}
"""What columns are for, by their names in lower case; the first that is there."""
GAPS = "its numbers of episodes have gaps: not every episode stands in it"
FEW = 5
"""Rows from which on lengths that only rise are taken for a count over all episodes."""


@dataclass(frozen=True)
class EpisodeCsv:
    """Episodes of one training, or of several where a column says of which a row is.

    Attributes:
        reward: The column of returns; found by its name if empty.
        length: That of lengths; found by its name if empty.
        success: That of success, 0 or 1; found by its name if empty.
        measure: That of one more measure, which no reward enters.
    """

    reward: str = ""
    length: str = ""
    success: str = ""
    measure: str = ""

    def recognises(self, path: Path, head: bytes) -> bool:
        """By columns of returns and of episodes or lengths, and first rows that are no steps."""
        text = head[: head.rfind(b"\n") + 1].decode("utf-8-sig", "ignore")
        if path.suffix.lower() not in (".csv", ".tsv", ".txt") or not text:
            return False
        try:
            table = parse_table(path, text, separator=_separator(text))
            roles = self._roles(table.names)
            return "reward" in roles and are_episodes(table, roles)
        except SchemaError:
            return False

    def read(self, path: Path) -> tuple[Log, ...]:
        """One log, or one for each run that a column names.

        Raises:
            UsageError: A column that was named is not there, or none of returns or success is known.
            SchemaError: It is damaged, or its rows are no episodes; names the line.
        """
        table = read_table(path, separator=_separator(first_line(path).decode("utf-8", "ignore")))
        require_columns(path, table.names, self.reward, self.length, self.success, self.measure)
        roles = self._roles(table.names)
        if not {"reward", "success"} & roles.keys():
            there = shortened(", ".join(table.names), 160)
            raise UsageError(f"{path} has no column of returns that is known: say reward=NAME. It has: {there}")
        if not len(table):
            raise SchemaError(f"{path} holds no episode yet")
        return tuple(_log(table, roles, run, rows) for run, rows in runs_in(table, roles))

    def write_example(self, folder: Path) -> Path:
        """Four episodes."""
        path = folder / "episodes.csv"
        rows = ["episode,reward,length,success", "0,-9.5,200,0", "1,-7.25,200,0", "2,-3.0,120,1", "3,-2.5,101,1"]
        path.write_text("\n".join(rows) + "\n", encoding="utf-8")
        return path

    def _roles(self, names: Sequence[str]) -> dict[str, str]:
        """By what it is for: the column."""
        lower = {name.lower(): name for name in reversed(names)}
        found = {role: next((lower[name] for name in of if name in lower), "") for role, of in ROLES.items()}
        given = {"reward": self.reward, "length": self.length, "success": self.success, "measure": self.measure}
        found |= {role: name for role, name in given.items() if name}
        return {role: name for role, name in found.items() if name}


def _separator(text: str) -> str:
    first = text.partition("\n")[0]
    return max(",;\t", key=first.count)


def _log(table: TextTable, roles: Mapping[str, str], run: str, rows: Ints) -> Log:
    fault = fault_of_episodes(table, roles, rows)
    if fault:
        raise table.refused(fault.row, fault.why)
    columns: dict[str, Float] = {}
    if "reward" in roles:
        columns[f"{REWARD}{RECORDED}"] = table.numbers(roles["reward"])[rows]
    if "success" in roles:
        columns[f"{BEHAVIOUR}{SUCCESS}"] = table.truths(roles["success"])[rows]
    if "measure" in roles:
        columns[f"{BEHAVIOUR}{roles['measure']}"] = table.numbers(roles["measure"])[rows]
    told = ", ".join(f"{role} from '{name}'" for role, name in roles.items())
    counts, notes = _counts(table, roles, rows)
    seed = run if roles.get("run", "").lower() in SEED else ""
    facts = LogFacts(
        path=table.path,
        format="table of episodes",
        unit="episode",
        run=run,
        seed=int(seed) if seed.isdecimal() else None,
        bounds={SUCCESS: (0.0, 1.0)} if "success" in roles else {},
        thinned=GAPS if _has_gaps(table, roles, rows) else "",
        notes=(told, *notes, *table.notes),
    )
    return in_memory(facts, {**columns, **counts})


def _counts(table: TextTable, roles: Mapping[str, str], rows: Ints) -> tuple[dict[str, Float], list[str]]:
    """Lengths, and the environment steps of the training, as far as they are told."""
    columns: dict[str, Float] = {}
    notes: list[str] = []
    if "length" in roles:
        lengths = table.counts(roles["length"], least=1)[rows]
        if len(lengths) >= FEW and (np.diff(lengths) > 0.0).all():
            notes.append(f"'{roles['length']}' only rises: it is taken to count the steps of all episodes")
            columns["time"] = lengths
        else:
            columns["length"] = lengths
            if not _has_gaps(table, roles, rows):
                columns["time"] = np.cumsum(lengths)
    if "time" in roles:
        columns["time"] = table.counts(roles["time"])[rows]
        back = np.flatnonzero(np.diff(columns["time"]) < 0.0)
        if len(back):
            raise table.refused(int(rows[back[0] + 1]), f"'{roles['time']}' goes back: the file holds several runs")
    return columns, notes


def _has_gaps(table: TextTable, roles: Mapping[str, str], rows: Ints) -> bool:
    if "episode" not in roles or "env" in roles:
        return False
    return bool((np.diff(table.numbers(roles["episode"])[rows]) != 1.0).any())
