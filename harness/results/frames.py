"""Pictures of evaluation episodes in environments, as a run left them; see `harness.experiment.environments.frames`."""

import hashlib
import json
from pathlib import Path
from typing import Annotated, NamedTuple

from pydantic import Field, TypeAdapter, with_config
from typing_extensions import TypedDict

from harness.errors import SchemaError
from harness.files.bounded import parse_json, read_bytes, reading
from harness.record.file_forms import EXACT, Line, Whole, require_form
from harness.record.folder import DERIVED, EVALUATION_RECORDING, POLICY
from harness.record.manifest import Manifest

FRAMES, STRIP = "frames.json", "frames.webp"
MOST_BYTES = 150_000
"""The most bytes of the pictures of one episode."""
MOST_FACTS = 20_000
NONE = "no pictures were drawn when the cells ended"


@with_config(EXACT)
class FramesForm(TypedDict):
    """The form of ``frames.json``."""

    made_of: Line
    reason: Line
    episode: Whole
    steps: Annotated[list[Whole], Field(max_length=100)]
    told: Line
    outcome: Line


FORM: TypeAdapter[FramesForm] = TypeAdapter(FramesForm)


class Frames(NamedTuple):
    """Pictures of one episode of a cell's evaluation."""

    reason: str
    """Why there is no picture; empty if there are some."""
    steps: tuple[int, ...] = ()
    """The step of each picture."""
    told: str = ""
    """What the episode was paid, and the measure that decides."""
    outcome: str = ""
    """How the episode ended."""
    strip: bytes = b""
    """All pictures side by side, as WebP."""
    episode: int = 0
    """The number of the episode, counted from 0."""


def frames_folder(folder: Path, cell: str) -> Path:
    """Where the pictures of a cell are kept.

    Args:
        folder: The folder of the experiment.
        cell: The id of the cell.
    """
    return folder / DERIVED / cell / "frames"


def made_of(done: Manifest) -> str:
    """A digest of the files of a done cell that its pictures follow from."""
    names = (f"{EVALUATION_RECORDING}/", f"{POLICY}/")
    told = {name: digest for name, digest in done.files.items() if name.startswith(names)}
    return hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()


def read_frames(folder: Path, done: Manifest) -> Frames:
    """The pictures of a done cell, or the reason why there are none. Files that are not sound are not shown.

    Args:
        folder: The folder of the experiment.
        done: What the cell says of itself.
    """
    place = frames_folder(folder, done.cell.id)
    if not (place / FRAMES).is_file():
        return Frames(NONE)
    try:
        with reading(place / FRAMES, "pictures of an episode"):
            data = parse_json(read_bytes(place / FRAMES, MOST_FACTS))
            require_form(FORM, data)
            if data["made_of"] != made_of(done):
                return Frames("the pictures are those of another training")
            if data["reason"]:
                return Frames(data["reason"])
            strip = read_bytes(place / STRIP, MOST_BYTES)
            return Frames("", tuple(data["steps"]), data["told"], data["outcome"], strip, data["episode"])
    except SchemaError as error:
        return Frames(str(error))
