"""What Weights & Biases exports: a chart with a column for each run, or the history of one run."""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from harness.errors import SchemaError
from harness.log import Log, LogFacts
from harness.log.text_table import TextTable, first_line, header_of, read_table

from ..curves import CLEANRL_RUN, CurveSettings, curve_log, is_history

BETWEEN = " - "
"""Stands between the name of a run and that of its curve."""
END = re.compile(r"__(MIN|MAX)$")
OWN_STEP = ("Step", "_step")
"""What counts how often a run has logged: the x axis of a chart, unless somebody chose another."""
SAMPLED = "Weights & Biases samples a curve before it exports it"
JOINED = "a value is a mean of several points, or of the runs of a group: its least and greatest differ"


@dataclass(frozen=True)
class WandBCsv(CurveSettings):
    """Curves that were exported from Weights & Biases; each run of a chart is a training."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """Columns ``RUN - CURVE`` with their least and greatest, or the columns of a run's history."""
        names = header_of(path, head)
        charted = [name for name in names[1:] if BETWEEN in name]
        is_chart = bool(charted) and (names[0] in OWN_STEP or any(map(END.search, charted)))
        return is_chart or is_history(names)

    def read(self, path: Path) -> tuple[Log, ...]:
        """The training of each run, by name.

        Raises:
            UsageError: A curve that was named is not there, or none is known.
            SchemaError: It is damaged; names the line.
        """
        is_quoted = first_line(path).startswith(b'"')
        table = read_table(path, ends_open=is_quoted)
        if is_history(table.names):
            named = {name: name for name in table.names}
            return (self._log(table, "", named, "_step"),)
        runs: dict[str, dict[str, str]] = {}
        for name in table.names[1:]:
            run, between, tag = name.rpartition(BETWEEN)
            if between and not END.search(tag):
                runs.setdefault(run, {})[tag] = name
        if not runs:
            raise SchemaError(f"{path} has no column RUN - CURVE")
        return tuple(self._log(table, run, tags, table.names[0]) for run, tags in sorted(runs.items()))

    def write_example(self, folder: Path) -> Path:
        """Two runs with three points each, as the page of a chart exports them."""
        path = folder / "wandb_export.csv"
        tag = "charts/episodic_return"
        names = [f"{run}{BETWEEN}{tag}{end}" for run in ("base", "shaped") for end in ("", "__MIN", "__MAX")]
        rows = [["global_step", *names]]
        for point, value in enumerate((-9.5, -4.25, -1.0)):
            rows.append([str(1000 * point), *[str(value + more) for more in (0.0, 0.5) for _ in range(3)]])
        path.write_text("\n".join(",".join(f'"{cell}"' for cell in row) for row in rows), encoding="utf-8")
        return path

    def _log(self, table: TextTable, run: str, tags: Mapping[str, str], axis: str) -> Log:
        curve = self.chosen(table.path, list(tags))._replace(counts=f"those of '{axis}'")
        wanted = [tag for tag in (*curve.columns.values(), *curve.time) if tag in tags]
        columns = {tag: table.numbers(tags[tag], may_lack=True) for tag in wanted}
        columns[axis if axis in curve.time else "step"] = table.numbers(axis)
        joined = any(_differ(table, tags[tag]) for tag in curve.columns.values())
        named = CLEANRL_RUN.fullmatch(run)
        facts = LogFacts(
            path=table.path,
            format="export of Weights & Biases" + (f", names of {curve.program}" if curve.program else ""),
            run=run,
            env=named["env"] if named else "",
            algorithm=named["algorithm"] if named else "",
            seed=int(named["seed"]) if named else None,
            thinned="; ".join([SAMPLED, *([JOINED] if joined else [])]),
            notes=table.notes,
        )
        return curve_log(facts, curve, list(tags), columns, self)


def _differ(table: TextTable, name: str) -> bool:
    """Whether the least and the greatest that stand beside a curve differ anywhere."""
    ends = [table.numbers(end, may_lack=True) for end in (f"{name}__MIN", f"{name}__MAX") if end in table.cells]
    return len(ends) == 2 and bool(np.nansum(np.abs(ends[0] - ends[1])) > 0.0)
