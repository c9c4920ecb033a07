"""``monitor.csv`` of stable-baselines3's Monitor: a line of JSON, then ``r,l,t`` of each episode."""

import json
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from harness.arrays import Float
from harness.errors import SchemaError
from harness.log import Log, LogFacts, in_memory
from harness.log.log import BEHAVIOUR, RECORDED, REWARD, SUCCESS, Columns
from harness.log.text_table import TextTable, first_line, read_table, require_columns

from ..zoo_settings import zoo_settings

SUCCESS_KEYS = ("is_success", "success")
OWN = ("r", "l", "t")
"""Return, length and seconds since the file was begun: the first columns of every such file, in this order."""
NAMELESS = "column "
PAY = re.compile(r"rew(ard)?|return|\bpay", re.IGNORECASE)
"""In the name of a column that is pay, and so no measure that no reward enters."""
FILE_NAME = re.compile(r"(.*\.)?monitor\.csv")
BARE_ROW = re.compile(rb"-?\d+(\.\d+)?(e[+-]?\d+)?,\d+,\d+(\.\d+)?(e[+-]?\d+)?,?")
"""The first line of a file that Monitor was to append to, and that was not there: it writes no header then."""


@dataclass(frozen=True)
class Monitor:
    """Episodes of one environment, or of several that train side by side, as Monitor and VecMonitor write them.

    Attributes:
        success: The column that says whether an episode was a success; found by its name if empty.
    """

    success: str = ""

    def recognises(self, path: Path, head: bytes) -> bool:
        """By the first line of JSON behind ``#`` and the columns, or by the file's name and a first row of numbers."""
        first, _, rest = head.lstrip(b"\xef\xbb\xbf").partition(b"\n")
        if re.match(rb"#\s*\{", first):
            return rest.lstrip().startswith(b"r,l,t")
        is_named = FILE_NAME.fullmatch(path.name) is not None
        return is_named and (first.startswith(b"r,l,t") or BARE_ROW.match(first) is not None)

    def read(self, path: Path) -> tuple[Log, ...]:
        """The one training of the file, or the one env of a training.

        Raises:
            UsageError: It has no such column of success.
            SchemaError: It is damaged: names the line.
        """
        table = read_table(path, comment="#", names=_names_of_a_bare_file(path))
        require_columns(path, table.names, self.success)
        if table.names[: len(OWN)] != OWN:
            raise SchemaError(f"{path}: its columns are {', '.join(table.names[:4])}; Monitor's begin with r, l, t")
        if not len(table):
            raise SchemaError(f"{path} holds no episode yet")
        headers = [_header(path, line, text) for line, text in table.comments]
        envs = sorted({str(header.get("env_id") or "") for header in headers})
        if len(envs) > 1:
            raise SchemaError(f"{path} holds episodes of several environments: {', '.join(envs)}")
        success = self.success or next((name for name in SUCCESS_KEYS if name in table.names), "")
        columns, notes = _columns(table, success)
        started = headers[0].get("t_start") if headers else None
        env = "" if envs in ([], ["None"]) else envs[0]
        zoo = zoo_settings(path, env)
        facts = LogFacts(
            path=path,
            format="Monitor of stable-baselines3",
            unit="episode",
            env=env or zoo.env,
            algorithm=zoo.algorithm,
            seed=zoo.seed,
            asked=zoo.asked,
            started=float(started) if isinstance(started, int | float) else None,
            bounds={SUCCESS: (0.0, 1.0)} if success else {},
            notes=(*notes, *table.notes, *_clock(table)),
        )
        return (in_memory(facts, columns),)

    def write_example(self, folder: Path) -> Path:
        """Three episodes of Pendulum under Monitor; the same lines where the library is not installed."""
        path = folder / "monitor.csv"
        try:
            import gymnasium
            from stable_baselines3.common.monitor import Monitor as Wrapper
        except ImportError:
            path.write_text('#{"t_start": 1.0, "env_id": "Toy-v0"}\nr,l,t\n-3.5,10,0.1\n-2.25,12,0.2\n-1.0,9,0.3\n')
            return path
        env = Wrapper(gymnasium.make("Pendulum-v1", max_episode_steps=5), str(path))
        for seed in range(3):
            env.reset(seed=seed)
            ended = False
            while not ended:
                _, _, terminated, truncated, _ = env.step(np.zeros(1, np.float32))
                ended = terminated or truncated
        env.close()
        return path


def _names_of_a_bare_file(path: Path) -> Sequence[str]:
    """Names of the columns of a file without a header; empty of one that has it."""
    first = first_line(path)
    if BARE_ROW.match(first) is None:
        return ()
    return (*OWN, *(f"{NAMELESS}{number}" for number in range(4, first.count(b",") + 2)))


def _header(path: Path, line: int, text: str) -> dict[str, Any]:
    try:
        told = json.loads(text.lstrip("#"))
    except (ValueError, RecursionError):
        told = None
    if not isinstance(told, dict):
        raise SchemaError(f"{path}, line {line}: behind # stands no JSON object")
    return told


def _columns(table: TextTable, success: str) -> tuple[Columns, list[str]]:
    """The columns by their standard names, and notes on what else there is."""
    lengths = table.counts("l", least=1)
    columns: dict[str, Float] = {f"{REWARD}{RECORDED}": table.numbers("r"), "length": lengths}
    columns |= {"time": np.cumsum(lengths), "seconds": table.numbers("t", may_lack=True)}
    if success:
        columns[f"{BEHAVIOUR}{SUCCESS}"] = table.truths(success)
    measured: list[str] = []
    left: list[str] = []
    for name in table.names[len(OWN) :]:
        values = None if name == success else _measured(table, name)
        if values is not None:
            columns[f"{BEHAVIOUR}{name}"] = values
        if name != success:
            (left if values is None else measured).append(name)
    notes = [f"Success is read from '{success}'"] if success else []
    notes += [f"taken as measures: {', '.join(measured)}"] if measured else []
    notes += [f"left out, as pay, text or without a name: {', '.join(left)}"] if left else []
    return columns, notes


def _measured(table: TextTable, name: str) -> Float | None:
    """A further column that can be a measure; None of pay, of what is no number everywhere, and of one without name."""
    if PAY.search(name) or name.startswith(NAMELESS):
        return None
    try:
        return table.numbers(name)
    except SchemaError:
        return None


def _clock(table: TextTable) -> list[str]:
    """What to tell of a file that was not written in one go."""
    back = np.flatnonzero(np.diff(table.numbers("t", may_lack=True)) < 0.0)
    if not len(back):
        return []
    first = table.lines[int(back[0]) + 1]
    return [f"its clock goes back {len(back)} times, first in line {first}: it was continued, or several envs write it"]
