"""How large the map is that a reader needs: ``python -m tests.architecture [--run] [--lower]``.

It prints each figure beside its bound, and ends with status 1 where one is above it. `--run` measures too what takes
running: which files commands enter. `--lower` writes today's figures as the bounds, where they are below them.
"""

import sys
import tempfile
import tomllib
from pathlib import Path

from tests.architecture.entered import measured_by_running
from tests.architecture.source import measured

BOUNDS = Path(__file__).with_name("bounds.toml")


def read_bounds():
    """The bound of each figure, in the order of the file."""
    return tomllib.loads(BOUNDS.read_text())


def above(figures, bounds):
    """A line for each figure that is above its bound, or has none."""
    return [
        f"{name}: {figure:g}, and the bound is {bounds.get(name, 'missing')}"
        for name, figure in figures.items()
        if not figure <= bounds.get(name, float("-inf"))
    ]


def lowered(figures, bounds):
    """The file of bounds, each no larger than its figure."""
    known = bounds | {name: min(figure, bounds.get(name, figure)) for name, figure in figures.items()}
    head = "# No figure of python -m tests.architecture may be larger. They only fall: --lower writes today's.\n"
    return head + "".join(f'"{name}" = {bound}\n' for name, bound in known.items())


def main(arguments):
    """Print the table; returns the exit status."""
    figures = measured()
    if "--run" in arguments:
        with tempfile.TemporaryDirectory() as folder:
            figures |= measured_by_running(Path(folder))
    if "--lower" in arguments:
        BOUNDS.write_text(lowered(figures, read_bounds()))
    bounds = read_bounds()
    rows = [f"{name:<52} {figure:>8g} {bounds.get(name, float('nan')):>8g}" for name, figure in figures.items()]
    grown = above(figures, bounds)
    print(f"{'':<52} {'today':>8} {'bound':>8}", *rows, *grown, sep="\n")  # noqa: T201
    return 1 if grown else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
