"""Pictures of evaluation episodes in environments, as a run left them; see `harness.experiment.environments.frames`."""

import hashlib
import json
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

from pydantic import Field, with_config

from harness.errors import SchemaError
from harness.files.bounded import is_whole, parse_json, read_keyed, reading
from harness.record.cell import Manifest
from harness.record.file_forms import EXACT, Line, Whole, read_form
from harness.record.folder import DERIVED, EVALUATION_RECORDING, POLICY
from harness.results.kept import write_kept

NAME = "frames"
"""The file in the folder of a cell's kept results: a line of JSON, then the pictures."""
MOST_BYTES = 150_000
"""The most bytes of the pictures of one episode."""
MOST_FACTS = 20_000
"""The most bytes of what is said of them."""
NONE = "no pictures were drawn when the cells ended"
FOREIGN = "the pictures are of another training, or another user or machine made them"


@with_config(EXACT)
@dataclass(frozen=True)
class Frames:
    """Pictures of one episode of a cell's evaluation, and what their file says of them.

    Attributes:
        reason: Why there is no picture; empty if there are some.
        steps: The step of each picture.
        told: What the episode was paid, and the measure that decides.
        outcome: How the episode ended.
        strip: All pictures side by side, as WebP.
        episode: The number of the episode, counted from 0.
    """

    reason: Line
    steps: Annotated[tuple[Whole, ...], Field(max_length=100)] = ()
    told: Line = ""
    outcome: Line = ""
    strip: bytes = b""
    episode: Whole = 0


def frames_file(folder: Path, cell: str, episode: int = 0) -> Path:
    """Where the pictures of an episode of a cell are kept.

    Args:
        folder: The folder of the experiment.
        cell: The id of the cell.
        episode: Counted from 0.
    """
    return folder / DERIVED / cell / (f"{NAME}-{episode}" if episode else NAME)


def made_of(done: Manifest) -> str:
    """The key of a done cell's pictures: a digest of the files that they follow from."""
    names = (f"{EVALUATION_RECORDING}/", f"{POLICY}/")
    told = {name: digest for name, digest in done.files.items() if name.startswith(names)}
    return f"frames {hashlib.sha256(json.dumps(told, sort_keys=True).encode()).hexdigest()}"


def read_frames(folder: Path, done: Manifest, episode: int = 0) -> Frames:
    """The pictures of an episode of a done cell, or the reason why there are none.

    Pictures of another training, and files that are not whole, are not shown.

    Args:
        folder: The folder of the experiment.
        done: What the cell says of itself.
        episode: Counted from 0.
    """
    path = frames_file(folder, done.cell.id, episode)
    content = read_keyed(path, made_of(done), MOST_BYTES + MOST_FACTS)
    if content is None:
        return Frames(FOREIGN if is_whole(path, MOST_BYTES + MOST_FACTS) else NONE)
    facts, _, strip = content.partition(b"\n")
    try:
        with reading(path, "file of pictures"):
            return replace(read_form(Frames, parse_json(facts)), strip=strip)
    except SchemaError as error:
        return Frames(str(error))


def write_frames(folder: Path, done: Manifest, content: bytes, episode: int = 0) -> None:
    """Keep the pictures of an episode of a done cell: a line of JSON as `Frames` has it, then the pictures.

    A folder that allows no writing stays as it is, and so does one that holds a link.
    """
    write_kept(folder / DERIVED, frames_file(folder, done.cell.id, episode), made_of(done), content)
