"""``monitor.csv`` of stable-baselines3's Monitor: a line of JSON, then ``r,l,t`` of each episode."""

import json
from collections.abc import Iterable
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.csv

from harness.errors import SchemaError
from harness.files.bounded import read_bytes, reading
from harness.log import Log, LogFacts
from harness.log.log import BEHAVIOUR, RECORDED, REWARD, SUCCESS, Columns

MOST_BYTES = 2**30
SUCCESS_KEYS = ("is_success", "success")


@dataclass(frozen=True)
class Monitor:
    """Episodes of one environment, or of several that train side by side, as Monitor and VecMonitor write them.

    Attributes:
        success: The column that says whether an episode was a success; found by its name if empty.
    """

    success: str = ""

    def recognises(self, path: Path, head: bytes) -> bool:
        """A first line of JSON behind ``#``, and a second that begins with the three columns."""
        first, _, rest = head.partition(b"\n")
        return first.startswith(b"#{") and rest.startswith(b"r,l,t")

    def read(self, path: Path) -> tuple[Log, ...]:
        """The one training of the file."""
        with reading(path, "Monitor file"):
            first, _, rest = read_bytes(path, MOST_BYTES).partition(b"\n")
            told = json.loads(first[1:])
            names = rest.partition(b"\n")[0].decode().strip().split(",")
        success = self.success or next((name for name in SUCCESS_KEYS if name in names), "")
        columns = {f"{REWARD}{RECORDED}": "r", "length": "l", "time": "l"}
        if success:
            columns[f"{BEHAVIOUR}{SUCCESS}"] = success
        facts = LogFacts(
            path=path,
            format="Monitor of stable-baselines3",
            unit="episode",
            env=str(told.get("env_id") or ""),
            started=told.get("t_start"),
        )
        return (Log(facts, tuple(columns), partial(_rows, path, columns)),)

    def write_example(self, folder: Path) -> Path:
        """Three episodes."""
        path = folder / "monitor.csv"
        path.write_text('#{"t_start": 1.0, "env_id": "Toy-v0"}\nr,l,t\n-3.5,10,0.1\n-2.25,12,0.2\n-1.0,9,0.3\n')
        return path


def _rows(path: Path, columns: dict[str, str], names: tuple[str, ...]) -> Iterable[Columns]:
    with reading(path, "Monitor file"):
        table = pa.csv.read_csv(path, pa.csv.ReadOptions(skip_rows=1))
        if table.num_rows == 0:
            return
        told = {name: np.asarray(table.column(name).to_numpy(), np.float64) for name in {*columns.values()}}
        if not all(np.isfinite(values).all() for values in told.values()):
            raise SchemaError(f"{path}: a number is missing or not finite")
        yield {name: np.cumsum(told["l"]) if name == "time" else told[columns[name]] for name in names}
