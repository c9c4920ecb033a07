"""Has environments draw an episode of the policies that are compared, for the report page.

Each cell's pictures are drawn in a process of its own: graphics libraries may crash where there is no screen.
"""

import io
import json
import tempfile
from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from harness.errors import HarnessError
from harness.executor import Limits, Word
from harness.experiment.environments.played_again import PlayedAgain
from harness.experiment.workers.order import Order, Report
from harness.experiment.workers.workers import News, run_orders
from harness.files.plain import Plain
from harness.record.cell import Cell, Manifest
from harness.record.folder import partial_folder, publish
from harness.registry.given import Given
from harness.registry.registry import load_registry
from harness.registry.spec import require_pillow
from harness.results.frames import MOST_BYTES, read_frames, write_frames
from harness.results.pairs import shown_pair
from harness.results.results import Results
from harness.text import one_line

if TYPE_CHECKING:
    from PIL import Image

DRAWN = "drawn"
"""The file that a process leaves: what is kept of the cell."""
PICTURES = 8
"""How many of an episode, side by side."""
WIDTH, HEIGHT = 160, 160
"""The most pixels of a picture."""
QUALITIES = (75, 50, 25, 5)
"""Qualities of WebP; the first one that is small enough is taken."""
MOST_COMPARISONS = 12
"""The most comparisons of which pictures are drawn: a page with all of them stays below 4 MB."""
LIMITS = Limits(stall_after=60.0, cell_time=120.0)


def draw_frames(results: Results, at_once: int) -> None:
    """Draw the typical pair of episodes of each comparison, as far as that was not done before.

    A cell whose environment cannot draw leaves the reason. A folder that allows no writing stays as it is.

    Args:
        results: The results whose page is going to show the pictures.
        at_once: How many processes draw.
    """
    missing = {
        f"{done.cell.id}-{number}": (done, number)
        for done, number in _shown(results)
        if not read_frames(results.folder, done, number).strip
    }
    if not missing:  # what could not be drawn before may be possible now
        return
    with tempfile.TemporaryDirectory(prefix="harness-frames-") as place:
        orders = [
            Order(
                Path(place) / name,
                DrawFrames(
                    done.cell, str(results.store.cell_folder(done.cell).absolute()), results.registry.given, number
                ),
                LIMITS,
            )
            for name, (done, number) in missing.items()
        ]
        reasons: dict[str, str] = {}

        def hear(news: News) -> None:
            if news.kind == "ended" and news.reason:
                reasons[news.folder.name] = news.reason

        run_orders(orders, at_once, hear)
        for name, (done, number) in missing.items():
            drawn = Path(place) / name / DRAWN
            content = (
                drawn.read_bytes() if drawn.is_file() else _told(reason=f"drawing failed: {reasons.get(name, '')}")
            )
            write_frames(results.folder, done, content, number)


def _shown(results: Results) -> list[tuple[Manifest, int]]:
    """The done cells of the pair that is shown of each comparison, and the number of the episode, each once."""
    shown: dict[tuple[Cell, int], None] = {}
    for it in [it for it in results.combinations if it.seeds and not it.is_control][:MOST_COMPARISONS]:
        if pair := shown_pair(results, it):
            shown |= {(cell, pair.number): None for cell in pair.cells}
    return [(results.manifest(cell), number) for cell, number in shown]


@dataclass(frozen=True)
class DrawFrames(Plain):
    """Draws an episode of one cell's evaluation, as a worker is told to do it."""

    cell: Cell
    files: str
    plugins: tuple[Given, ...] = ()
    episode: int = 0

    noun: ClassVar[str] = "drawing"

    def do(self, folder: Path, report: Report) -> bool:
        report(Word(0))
        try:
            require_pillow()
            played = PlayedAgain(self.cell, Path(self.files), load_registry(given=self.plugins))
            with closing(played):
                content = _draw(played, self.episode)
        except HarnessError as error:
            content = _told(reason=one_line(str(error)))
        partial = partial_folder(folder)
        partial.mkdir(parents=True, exist_ok=True)
        (partial / DRAWN).write_bytes(content)
        publish(partial, folder)
        return True


def _draw(played: PlayedAgain, episode: int) -> bytes:
    """What there is to say of an episode, and its pictures."""
    if len(played.episodes) <= episode:
        return _told(reason="no episode of the evaluation ended")
    rows = played.episodes[episode]
    clock = np.unique(np.linspace(0, len(rows), PICTURES).round().astype(int))
    played.skip(episode)
    pictures = played.play(episode, clock)
    steps = [int(step) for step in clock if int(step) in pictures]
    strip, _ = strip_of([pictures[step] for step in steps], (WIDTH, HEIGHT), MOST_BYTES)
    if not strip:
        return _told(reason=f"the pictures take more than {MOST_BYTES:,} bytes")
    return _told(episode=episode, steps=steps, told=played.told(rows), outcome=played.outcome(rows)) + strip


def strip_of(pictures: Sequence["Image.Image"], size: tuple[int, int], most: int) -> tuple[bytes, tuple[int, int]]:
    """All pictures side by side, as WebP, empty if they would take more than `most` bytes; and the size of each."""
    from PIL import Image, ImageOps

    small = [ImageOps.contain(picture.convert("RGB"), size) for picture in pictures]
    width, height = small[0].size
    whole = Image.new("RGB", (width * len(small), height))
    for number, picture in enumerate(small):
        whole.paste(picture, (number * width, 0))
    for quality in QUALITIES:
        file = io.BytesIO()
        whole.save(file, "WEBP", quality=quality, method=4)
        if file.tell() <= most:
            return file.getvalue(), (width, height)
    return b"", (width, height)


def _told(**facts: Any) -> bytes:
    """What is said of pictures, a line; see `harness.results.frames.Frames`."""
    return f"{json.dumps({'reason': '', **facts})}\n".encode()
