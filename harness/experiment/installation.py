"""What a machine has installed, as far as it decides results: told there, compared here."""

import platform
from collections.abc import Iterable, Mapping

from harness.experiment.provenance import specs_of, versions_behind
from harness.hookspecs import NOUNS
from harness.record.cell import Cell
from harness.registry.registry import Registry
from harness.registry.sources import digest_of_modules, source_hash
from harness.robot.load import load_robot

DIGITS = 8
"""Of a digest, as it is told and compared."""


def describe_installation(cells: Iterable[Cell], registry: Registry) -> dict[str, str]:
    """Versions of Python and of the distributions behind some cells, digests of the sources and the robots.

    Raises:
        UsageError: A plugin, a library or a robot of the cells is not there.
        PluginError: A plugin cannot be imported.
    """
    cells = list(cells)
    specs = {(kind, spec.name): spec for cell in cells for kind, spec in specs_of(cell, registry).items()}
    plugins = {f"source of {NOUNS[kind]} '{name}'": source_hash(spec.load()) for (kind, name), spec in specs.items()}
    robots = {f"robot '{robot}'": load_robot(robot, registry).digest for robot in {cell.robot: None for cell in cells}}
    digests = {"source of harness": digest_of_modules(["harness"]), **plugins, **robots}
    return {
        "python": platform.python_version(),
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
