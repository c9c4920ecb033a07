"""The pictures of a film of policies in an environment: the episodes of their evaluations, played again and drawn."""

from collections.abc import Iterator, Sequence
from contextlib import ExitStack, closing
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from harness.errors import UsageError
from harness.experiment.environments.played_again import PlayedAgain
from harness.record import Cell
from harness.registry.spec import require_pillow
from harness.results import Results
from harness.results.replay import find_done
from harness.scene.picture import BACKGROUND

from .film import COLOURS, HEIGHT, WIDTH, Frame, clock_of, frame_of, view_of

if TYPE_CHECKING:
    from PIL import Image

Box: TypeAlias = tuple[int, int, int, int]
"""Left, top, right and bottom of a part of a picture, in pixels."""
STILL, AIR = 24, 0.15
"""How much a colour differs, 0 to 255, where nothing moves; the air around what moves, as a share of its size."""


def environment_film(results: Results, ids: Sequence[str], episodes: int) -> Iterator[Frame]:
    """The first episodes of the evaluations of some cells beside one another, one after the other.

    Args:
        results: Of an experiment whose task is an environment.
        ids: Of done cells, or how they begin; without any, the baseline and the reward after it, of one seed.
        episodes: How many, at most.

    Raises:
        UsageError: No such cell is done, pillow is missing, or an env draws nothing or does not repeat its episodes.
        SchemaError: A file of a cell is damaged.
    """
    require_pillow()
    cells = [find_done(results, name) for name in ids] or _first_cells(results)
    with ExitStack() as opened:
        sides = [
            opened.enter_context(closing(_Side(cell, results.store.cell_folder(cell), results.registry)))
            for cell in cells
        ]
        for number in range(min(episodes, *(len(side.episodes) for side in sides))):
            yield from _episode(sides, number)


def _first_cells(results: Results) -> list[Cell]:
    """The baseline, and the first reward that was trained beside it with the same seed."""
    done = [manifest.cell for manifest in results.done]
    for first in (cell for cell in done if cell.reward.label == results.baseline):
        for other in done:
            same = (other.task, other.algorithm, other.seed) == (first.task, first.algorithm, first.seed)
            if same and other.reward != first.reward:
                return [first, other]
    if not done:
        raise UsageError(f"'{results.folder}' has nothing to show: no cell is done")
    return done[:1]


def _episode(sides: Sequence["_Side"], number: int) -> Iterator[Frame]:
    last = max(len(side.episodes[number]) for side in sides)
    clock = np.unique(np.rint(clock_of(last)).astype(int))
    played = [side.play(number, clock) for side in sides]
    box = box_of([picture for pictures in played for picture in pictures.values()])
    for step in clock:
        views = [
            side.view(number, step, pictures, box, COLOURS[index % len(COLOURS)])
            for index, (side, pictures) in enumerate(zip(sides, played, strict=True))
        ]
        yield frame_of(views, f"episode {number}, step {step} of {last}", step == clock[-1])


class _Side(PlayedAgain):
    """One cell, as a film shows it."""

    def view(
        self, number: int, step: int, pictures: dict[int, "Image.Image"], box: Box | None, colour: str
    ) -> "Image.Image":
        """How it stands at a step of an episode, in a part of the pictures; in all of them if there is no box."""
        rows, title = self.episodes[number], f"{self.cell.reward.label} · seed {self.cell.seed}"
        at = min(step, len(rows))
        told, outcome = self.told(rows[:at]), self.outcome(rows) if at == len(rows) else ""
        return view_of(_on_background(pictures[at].crop(box)), title, told, colour, outcome)


def box_of(pictures: Sequence["Image.Image"]) -> Box | None:
    """The part of pictures in which something moves, and some air; None where nothing moves or their sizes differ."""
    if len({picture.size for picture in pictures}) != 1:
        return None
    seen = np.stack([np.asarray(picture.convert("RGB"), np.int16) for picture in pictures])
    moves = (np.ptp(seen, axis=0) > STILL).any(axis=-1)
    if not moves.any():
        return None
    rows, columns = (np.flatnonzero(moves.any(axis=axis)) for axis in (1, 0))
    width, height = pictures[0].size
    across, down = float(np.ptp(columns)), float(np.ptp(rows))
    air = AIR * max(across, down, min(width, height) / 4)
    wide, high = across + 2 * air, down + 2 * air
    wide, high = max(wide, high * WIDTH / HEIGHT), max(high, wide * HEIGHT / WIDTH)  # as a film's picture is
    left, right = _within((columns[0] + columns[-1]) / 2, wide, width)
    top, bottom = _within((rows[0] + rows[-1]) / 2, high, height)
    return left, top, right, bottom


def _within(middle: float, size: float, most: int) -> tuple[int, int]:
    """The ends of a stretch around `middle`, moved to where it fits into 0 to `most`."""
    size = min(size, most)
    begin = min(max(middle - size / 2, 0.0), most - size)
    return round(begin), round(begin + size)


def _on_background(drawn: "Image.Image") -> "Image.Image":
    """A picture in the middle of one that is as large as a film needs it."""
    from PIL import Image, ImageOps

    whole = Image.new("RGB", (WIDTH, HEIGHT), BACKGROUND)
    picture = ImageOps.contain(drawn, (WIDTH, HEIGHT))
    whole.paste(picture, ((WIDTH - picture.width) // 2, (HEIGHT - picture.height) // 2))
    return whole
