"""Broken trackers."""

import json
from dataclasses import dataclass

from . import mutant


@dataclass(frozen=True)
class Sound:
    """A file of lines for each cell."""

    def why_not(self):
        return ""

    def begin(self, cell):
        return Track(cell.folder / cell.id)


@dataclass
class Track:
    """Of a cell."""

    path: object

    def log(self, steps, scalars):
        with self.path.open("a") as file:
            file.write(json.dumps([steps, scalars]) + "\n")

    def end(self, outcome, reason):
        self.log(0, {outcome: reason})


class Strict(Track):
    """Takes finite numbers alone."""

    def log(self, steps, scalars):
        json.dumps(scalars, allow_nan=False)


class Failing(Track):
    """Has no word for a failure."""

    def end(self, outcome, reason):
        {"done": 0, "interrupted": 1}[outcome]


class Shared(Track):
    """All cells have one file, which the first that ends removes."""

    def end(self, outcome, reason):
        (self.path.parent / "all").unlink()

    def log(self, steps, scalars):
        (self.path.parent / "all").write_text(str(scalars))


def of(track):
    """A tracker with another track."""
    return mutant(Sound, begin=lambda self, cell: track(cell.folder / cell.id))


MUTANTS = {
    "cannot be used": (
        "tracker-cells",
        mutant(Sound, why_not=lambda self: "no server"),
        "be used here: no server",
    ),
    "finite alone": ("tracker-cells", of(Strict), "raised ValueError"),
    "cannot fail": ("tracker-cells", of(Failing), "raised KeyError"),
    "one file": ("tracker-cells", of(Shared), "raised FileNotFoundError"),
}
SOUND = (Sound(),)
