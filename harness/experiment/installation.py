"""Describes what is installed on a machine, as far as it decides results, and compares two machines."""

import json
import platform
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar, Final

from harness.errors import HarnessError, UsageError, one_line
from harness.experiment.provenance import blas_kernel, specs_of, versions_behind
from harness.experiment.workers.order import Order, Report
from harness.experiment.workers.workers import run_orders
from harness.files.plain import Plain
from harness.hookspecs import NOUNS
from harness.record.cell import KERNEL, Cell
from harness.record.folder import partial_folder, publish
from harness.registry.choice import Registry
from harness.registry.given import Given
from harness.registry.registry import load_registry
from harness.registry.sources import digest_of_modules, source_hash
from harness.robot.robot import load_robot

DIGITS: Final = 8
"""Length of the digests that are exchanged and compared."""
ANSWER: Final = "installation.json"
PROBLEM: Final = "problem"


def describe_installation(cells: Iterable[Cell], registry: Registry) -> dict[str, str]:
    """Versions of Python and of the distributions behind some cells, kernel, digests of the sources and the robots.

    Raises:
        UsageError: A plugin, a library or a robot of the cells is not there.
        PluginError: A plugin cannot be imported.
    """
    cells = list(cells)
    specs = {(kind, spec.name): spec for cell in cells for kind, spec in specs_of(cell, registry).items()}
    plugins = {f"source of {NOUNS[kind]} '{name}'": source_hash(spec.load()) for (kind, name), spec in specs.items()}
    arms = {cell.robot: load_robot(cell.robot, registry) for cell in cells if "robots" in cell.plugins}
    driven = {cell.robot for cell in cells if cell.drives_with_servo}
    robots = {f"robot '{name}'": arm.driven_digest if name in driven else arm.digest for name, arm in arms.items()}
    digests = {"source of harness": digest_of_modules(["harness"]), **plugins, **robots}
    return {
        "python": platform.python_version(),
        KERNEL: blas_kernel(),
        **versions_behind(specs.values()),
        **{name: digest[:DIGITS] for name, digest in digests.items() if digest},
    }


def differences(here: Mapping[str, str], there: Mapping[str, str]) -> list[str]:
    """What two machines do not have in common, ``numpy 2.4.6 here, 2.3.0 there``."""
    return [
        f"{name} {here.get(name, 'none')} here, {there.get(name, 'none')} there"
        for name in {**here, **there}
        if here.get(name) != there.get(name)
    ]


def describe_workers(cells: Iterable[Cell], plugins: Sequence[Given] = ()) -> dict[str, str]:
    """`describe_installation`, of a worker process that is started here: it may find other modules than this one.

    Raises:
        UsageError: A plugin, a library or a robot of the cells is not there, or the process cannot start.
    """
    reasons: list[str] = []
    with tempfile.TemporaryDirectory(prefix="harness-") as place:
        folder = Path(place) / "answer"
        run_orders(
            [Order(folder, Describe(tuple(cells), tuple(plugins)), fresh=True)],
            1,
            lambda news: reasons.append(news.reason),
        )
        if any(reasons):
            raise UsageError("".join(reasons))
        told: dict[str, str] = json.loads((folder / ANSWER).read_text(encoding="utf-8"))
    if PROBLEM in told:
        raise UsageError(told[PROBLEM])
    return told


@dataclass(frozen=True)
class Describe(Plain):
    """`describe_installation`, as a worker is told to do it; what is missing is told too."""

    cells: tuple[Cell, ...]
    plugins: tuple[Given, ...] = ()

    noun: ClassVar[str] = "description"

    def do(self, folder: Path, report: Report) -> bool:
        try:
            told = describe_installation(self.cells, load_registry(given=self.plugins))
        except HarnessError as error:
            told = {PROBLEM: one_line(error)}
        (partial_folder(folder) / ANSWER).write_text(json.dumps(told), encoding="utf-8")
        publish(partial_folder(folder), folder)
        return True
