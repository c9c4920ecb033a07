"""The ratios of `make bench` as a record, and all records as one figure over time.

    python -m tests.bench.records build/bench.json results/reference/bench

writes ``results/reference/bench/DATE.json`` with version, commit and machine, and draws ``over-time.svg`` beside it.
"""

import json
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from datetime import UTC, datetime
from importlib.metadata import version
from pathlib import Path

import harness
from harness.experiment.provenance import describe_machine, source_commit
from harness.report.figures.chart import Axis, Chart, Dots, Flag, Note
from harness.report.figures.split import ticks
from harness_plugins.committed import TitledChart, draw_svg

BEHIND = ("gymnasium", "mujoco", "numpy", "pybullet", "stable-baselines3", "torch")
"""The packages that the ratios depend on."""
FIGURE = "over-time.svg"
TITLE = "How far the speeds are above their bounds"
SHOWN = 3
"""Records that the figure shows, the last ones."""
COLOURS = ("random", "baseline", "proposed")
"""Of the records, the last one last."""
ROW, WIDTH = 15.0, 900.0
"""Height of a row, and width of the panel, [px]."""


@dataclass(frozen=True)
class Record:
    """What one run of `make bench` measured.

    Attributes:
        date: Of the run, ISO 8601.
        version: Of the harness.
        commit: Of the repository.
        machine: CPU and number of cores.
        versions: Of the packages in `BEHIND`.
        ratios: By the name of a timing its ``ratio`` and the bound, ``at_least``.
    """

    date: str
    version: str
    commit: str
    machine: str
    versions: Mapping[str, str]
    ratios: Mapping[str, Mapping[str, float]]

    @property
    def title(self):
        """Date, commit and machine."""
        return f"{self.date}, {self.commit or self.version}, {self.machine}"


def record_of(ratios, root):
    """What was measured now, on this machine, with the checkout in `root`."""
    machine = describe_machine()
    return Record(
        datetime.now(UTC).date().isoformat(), harness.__version__, source_commit(root)[:8],
        f"{machine['cpu']}, {machine['cores']} cores", {name: version(name) for name in BEHIND}, ratios,
    )  # fmt: skip


def read_records(folder):
    """The records in a folder, the oldest first."""
    return [Record(**json.loads(path.read_text())) for path in sorted(folder.glob("*.json"))]


def draw_records(records):
    """A row for each timing of the last record: its ratio by its bound, of that record and those before."""
    shown = records[-SHOWN:]
    names = list(shown[-1].ratios)
    rows = {name: float(len(names) - place) for place, name in enumerate(names)}
    dots = [_dots(record, rows, colour) for record, colour in zip(shown, COLOURS[-len(shown) :], strict=True)]
    every = [value for mark in dots for value in mark.x]
    low, high = min(0.8, *every) / 1.05, max(every) * 1.1
    x = Axis(low, high, "ratio by its bound", tuple((tick, f"{tick:g}") for tick in ticks(low, high)), is_log=True)
    y = Axis(0.3, len(names) + 0.7, "", tuple((row, name) for name, row in rows.items()), has_grid=False)
    notes = [Note(rows[name], f"{shown[-1].ratios[name]['ratio']:.3g}") for name in names]
    chart = Chart(x, y, (*dots, *notes, Flag(1.0, "bound")), height=ROW * len(names) + 12.0, width=WIDTH)
    return draw_svg(TITLE, [TITLE, "At the right: the last ratio itself."], [TitledChart("", chart)])


def _dots(record, rows, colour):
    found = {name: it["ratio"] / it["at_least"] for name, it in record.ratios.items() if name in rows}
    told = tuple(f"{name}: {record.ratios[name]['ratio']:.3g} ({record.title})" for name in found)
    return Dots(list(found.values()), [rows[name] for name in found], colour, told, legend=record.title)


def main(measured, folder):
    """Write a record of what was measured, and draw all."""
    record = record_of(json.loads(measured.read_text()), Path(__file__).parents[2])
    folder.mkdir(parents=True, exist_ok=True)
    (folder / f"{record.date}.json").write_text(json.dumps(asdict(record), indent=1) + "\n")
    (folder / FIGURE).write_bytes(draw_records(read_records(folder)))


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
