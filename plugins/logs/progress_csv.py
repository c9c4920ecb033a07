"""``progress.csv`` of RLlib, stable-baselines3, baselines and garage, ``progress.txt`` of Spinning Up."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from harness.files.bounded import read_json
from harness.log import Log, LogFacts
from harness.log.text_table import first_line, header_of, read_table

from ..curves import Curve, CurveSettings, curve_log, is_history, is_known

ITERATIONS = ("training_iteration", "time/iterations", "Epoch", "Iteration", "iteration")
"""Columns that count rows."""
SETTINGS = ("params.json", "config.json")
"""What RLlib and Spinning Up keep beside it: the settings of the training."""


@dataclass(frozen=True)
class ProgressCsv(CurveSettings):
    """Learning curves that a training wrote into a table, a row for each of its reports."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """By a column that a table of names knows as some program's mean return."""
        names = header_of(path, head, _separator(head))
        return is_known(names) and not is_history(names)

    def read(self, path: Path) -> tuple[Log, ...]:
        """The one training of the file.

        Raises:
            UsageError: A column that was named is not there, or none is known.
            SchemaError: It is damaged, or its values do not stand under their names; names the line.
        """
        separator = _separator(first_line(path))
        table = read_table(path, wanted=lambda names: self._wanted(path, names), separator=separator)
        curve = self.chosen(path, table.names)._replace(counts="reports of the training")
        columns = {name: table.numbers(name, may_lack=True) for name in curve.columns.values()}
        columns |= {name: table.counts(name, may_lack=True) for name in _counters(curve, table.names)}
        step = next((columns[name] for name in ITERATIONS if name in columns), np.arange(1.0, len(table) + 1.0))
        told = _settings_beside(path)
        seed = told.get("seed")
        is_seed = isinstance(seed, int) and not isinstance(seed, bool)
        facts = LogFacts(
            path=path,
            format=f"table of progress, names of {curve.program}" if curve.program else "table of progress",
            env=_text(told, "env", "env_name"),
            algorithm=_text(told, "exp_name"),
            seed=seed if is_seed else None,
            notes=table.notes,
        )
        return (curve_log(facts, curve, table.names, {**columns, "step": step}, self),)

    def write_example(self, folder: Path) -> Path:
        """Three reports by stable-baselines3's own logger; the same lines where it is not installed."""
        path = folder / "progress.csv"
        rows = [(-9.5, 20.0, 2048), (-7.0, 18.0, 4096), (-2.5, 11.0, 6144)]
        names = ("rollout/ep_rew_mean", "rollout/ep_len_mean", "time/total_timesteps")
        try:
            from stable_baselines3.common.logger import CSVOutputFormat
        except ImportError:
            lines = [",".join(map(str, row)) for row in (names, *rows)]
            path.write_text("\n".join(lines) + "\n", encoding="utf-8")
            return path
        writer = CSVOutputFormat(str(path))
        for row in rows:
            writer.write(dict(zip(names, row, strict=True)), dict.fromkeys(names, ()))
        writer.close()
        return path

    def _wanted(self, path: Path, names: Sequence[str]) -> list[str]:
        """Few of the columns: RLlib's tables have hundreds."""
        curve = self.chosen(path, names)
        return [*curve.columns.values(), *_counters(curve, names)]


def _counters(curve: Curve, names: Sequence[str]) -> list[str]:
    return [name for name in (*curve.time, *ITERATIONS) if name in names]


def _separator(head: bytes) -> str:
    first = head.partition(b"\n")[0]
    return "\t" if b"\t" in first and b"," not in first else ","


def _settings_beside(path: Path) -> Mapping[str, Any]:
    """The settings of the training, where a program left them in the same folder; empty if they cannot be read."""
    for name in SETTINGS:
        try:
            told = read_json(path.with_name(name))
        except (OSError, ValueError):
            continue
        if isinstance(told, dict):
            return told
    return {}


def _text(told: Mapping[str, Any], *keys: str) -> str:
    return next((told[key] for key in keys if isinstance(told.get(key), str)), "")
