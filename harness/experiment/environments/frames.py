"""Has environments draw an episode of the policies that are compared, for the report page.

Each cell's pictures are drawn in a process of its own: graphics libraries may crash where there is no screen.
"""

import io
import json
from collections.abc import Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Self

import numpy as np

from harness.errors import HarnessError
from harness.executor import Limits, Word
from harness.experiment.environments.played_again import PlayedAgain
from harness.experiment.workers.order import Order, Report
from harness.experiment.workers.workers import News, run_orders
from harness.record.cell import Cell
from harness.record.folder import partial_folder, publish
from harness.record.manifest import Manifest
from harness.registry.given import Given, given_from_json, given_to_json
from harness.registry.registry import load_registry
from harness.results.comparison import Group
from harness.results.frames import FRAMES, MOST_BYTES, STRIP, frames_folder, made_of, read_frames
from harness.results.recordings.results import RecordedResults
from harness.scene.picture import require_pillow
from harness.text import one_line_of

if TYPE_CHECKING:
    from PIL import Image

PICTURES = 8
"""How many of an episode, side by side."""
WIDTH, HEIGHT = 160, 160
"""The most pixels of a picture."""
QUALITIES = (75, 50, 25, 5)
"""Qualities of WebP; the first one that is small enough is taken."""
MOST_COMPARISONS = 12
"""The most comparisons of which pictures are drawn: a page with all of them stays below 4 MB."""
LIMITS = Limits(stall_after=60.0, cell_time=120.0)


def draw_frames(results: RecordedResults, at_once: int) -> None:
    """Draw the first episode of one seed of each comparison, as far as that was not done before.

    A cell whose environment cannot draw leaves the reason. A folder that allows no writing stays as it is.

    Args:
        results: The results whose page is going to show the pictures.
        at_once: How many processes draw.
    """
    missing = [done for done in _shown(results) if _is_missing(results.folder, done)]
    orders = [
        Order(
            frames_folder(results.folder, done.cell.id),
            DrawFrames(done.cell, str(results.store.cell_folder(done.cell)), made_of(done), results.registry.given),
            LIMITS,
        )
        for done in missing
    ]
    digests = {frames_folder(results.folder, done.cell.id): made_of(done) for done in missing}

    def hear(news: News) -> None:
        if news.kind == "ended" and news.reason:
            _leave(news.folder, {"made_of": digests[news.folder], "reason": f"drawing failed: {news.reason}"})

    try:
        run_orders(orders, at_once, hear)
    except OSError:
        return


def _shown(results: RecordedResults) -> list[Manifest]:
    """The done cells of the first seed of each comparison, each once."""
    cells = {(it.reward.label, it.seed, Group.of(it)): it for it in results.done_cells}
    shown: dict[Cell, None] = {}
    for it in [it for it in results.combinations if it.seeds and not it.is_control][:MOST_COMPARISONS]:
        for reward in (it.baseline, it.proposed):
            shown[cells[reward, it.seeds[0], it.group]] = None
    return [results.manifest(cell) for cell in shown]


def _is_missing(folder: Path, done: Manifest) -> bool:
    return not read_frames(folder, done).strip  # what could not be drawn may be possible now


@dataclass(frozen=True)
class DrawFrames:
    """Draws the first episode of one cell's evaluation, as a worker is told to do it."""

    cell: Cell
    files: str
    made_of: str
    plugins: tuple[Given, ...] = ()

    noun: ClassVar[str] = "drawing"

    def to_json(self) -> dict[str, Any]:
        """See `harness.experiment.workers.order.Work`."""
        told = {"cell": self.cell.to_json(), "plugins": given_to_json(self.plugins)}
        return {**told, "files": self.files, "made_of": self.made_of}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """See `harness.experiment.workers.order.Work`."""
        plugins = given_from_json(data["plugins"])
        return cls(Cell.from_json(data["cell"]), data["files"], data["made_of"], plugins)

    def do(self, folder: Path, report: Report) -> bool:
        """See `harness.experiment.workers.order.Work`."""
        report(Word(0))
        try:
            require_pillow()
            played = PlayedAgain(self.cell, Path(self.files), load_registry(given=self.plugins))
            with closing(played):
                facts, strip = _draw(played)
        except HarnessError as error:
            _leave(folder, {"made_of": self.made_of, "reason": one_line_of(str(error))})
        else:
            _leave(folder, {"made_of": self.made_of, **facts}, strip)
        return True


def _draw(played: PlayedAgain) -> tuple[dict[str, Any], bytes]:
    """What there is to say of the first episode, and its pictures."""
    if not played.episodes:
        return {"reason": "no episode of the evaluation ended"}, b""
    rows = played.episodes[0]
    clock = np.unique(np.linspace(0, len(rows), PICTURES).round().astype(int))
    pictures = played.play(0, clock)
    steps = [int(step) for step in clock if int(step) in pictures]
    strip = _strip([pictures[step] for step in steps])
    if not strip:
        return {"reason": f"the pictures take more than {MOST_BYTES:,} bytes"}, b""
    return {"steps": steps, "told": played.told(rows), "outcome": played.outcome(rows)}, strip


def _strip(pictures: Sequence["Image.Image"]) -> bytes:
    """All pictures side by side, as WebP; empty if they would be too large."""
    from PIL import Image, ImageOps

    small = [ImageOps.contain(picture.convert("RGB"), (WIDTH, HEIGHT)) for picture in pictures]
    width, height = small[0].size
    whole = Image.new("RGB", (width * len(small), height))
    for number, picture in enumerate(small):
        whole.paste(picture, (number * width, 0))
    for quality in QUALITIES:
        file = io.BytesIO()
        whole.save(file, "WEBP", quality=quality, method=4)
        if file.tell() <= MOST_BYTES:
            return file.getvalue()
    return b""


def _leave(folder: Path, facts: Mapping[str, Any], strip: bytes = b"") -> None:
    partial = partial_folder(folder)
    partial.mkdir(parents=True, exist_ok=True)
    told = {"reason": "", "episode": 0, "steps": [], "told": "", "outcome": "", **facts}
    (partial / FRAMES).write_text(json.dumps(told), encoding="utf-8")
    if strip:
        (partial / STRIP).write_bytes(strip)
    publish(partial, folder)
