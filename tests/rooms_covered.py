"""How much of each room the tests run: ``python -m tests.rooms_covered coverage.json [PATHS of tests ...]``.

`make coverage` calls it after the tests. It prints a row for each room, the rooms of those tests alone where some are
given, and ends with status 1 where less than `LEAST` percent of a room's branches are run.
"""

import json
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

LEAST = 90.0
"""Percent of a room's branches."""
LIBRARIES = {
    "plugins/environments/fetch_reach.py": "gymnasium_robotics",
    "plugins/environments/meta_world.py": "metaworld",
    "plugins/simulators/drake.py": "pydrake",
    "plugins/simulators/mjx.py": "jax",
    "plugins/simulators/physx.py": "sapien",
}
"""What files need that `make dev` does not install: without it no test runs them, and they do not count."""
CLUSTERS = ("plugins/ray_cluster/", "plugins/slurm_array/", "plugins/executors/ray.py", "plugins/executors/slurm.py")
"""What works on a cluster: its tests are slow ones, and it does not count either."""


class Room(NamedTuple):
    """What the tests ran of a room's files."""

    name: str
    branches: int
    branches_run: int
    lines: int
    lines_run: int

    @property
    def share(self):
        """Of its branches, in percent; all of none is 100."""
        return 100.0 * self.branches_run / self.branches if self.branches else 100.0

    def __str__(self):
        """A row of the table."""
        lines = 100.0 * self.lines_run / self.lines if self.lines else 100.0
        return f"{self.name:<36} {self.branches:>8} {self.share:>7.1f} % {self.lines:>8} {lines:>7.1f} %"


def room_of(file):
    """The room that a file stands in: `harness/eta` or `plugins/rewards`; `harness` of a flat module."""
    top, *inner = Path(file).parts
    return f"{top}/{inner[0]}" if len(inner) > 1 else top


def rooms_of(files, installed):
    """By name.

    Args:
        files: What coverage.py tells of each file, by its path from the root.
        installed: Of the libraries in `LIBRARIES`, those that are there.
    """
    sums = {}
    for file, told in files.items():
        if file.startswith(CLUSTERS) or LIBRARIES.get(file, "") not in {"", *installed}:
            continue
        summary = told["summary"]
        names = ("num_branches", "covered_branches", "num_statements", "covered_lines")
        counted = sums.setdefault(room_of(file), [0, 0, 0, 0])
        counted[:] = [count + summary[name] for count, name in zip(counted, names, strict=True)]
    return [Room(name, *counts) for name, counts in sorted(sums.items())]


def wanted(room, tests):
    """Whether a room is that of some of the tests, which stand at the same place below `tests/`; of all if none."""
    places = {path.rstrip("/").removeprefix("tests/") for path in tests}
    return not tests or bool(places & {room, room.removeprefix("harness/")})


def main(report, *tests):
    """Print the table; returns the exit status."""
    installed = [library for library in LIBRARIES.values() if find_spec(library)]
    rooms = rooms_of(json.loads(Path(report).read_text())["files"], installed)
    rooms = [room for room in rooms if wanted(room.name, tests)]
    print(f"{'room':<36} {'branches':>8} {'run':>9} {'lines':>8} {'run':>9}", *rooms, sep="\n")  # noqa: T201
    short = [room.name for room in rooms if room.share < LEAST]
    if short:
        print(f"Below {LEAST:g} % of the branches: {', '.join(short)}. Add tests of what nothing runs there.")  # noqa: T201
    return 1 if short else 0


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
