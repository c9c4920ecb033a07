"""Films as files: GIF by pillow, MP4 by ffmpeg.

A GIF begins with its last picture, which is how the last episode ended: where only one picture of it is seen, it is
this one.
"""

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from harness.authoring.commands import TARGET, whole_file
from harness.errors import UsageError

from .film import COLOURS, INK, RATE, Frame

if TYPE_CHECKING:
    from PIL import Image

SHARED, LINES = 40, (*COLOURS, TARGET, INK, "#ffffff")
"""Colours of a GIF; all of its pictures have the same."""
KINDS = (".gif", ".mp4")


def require_kind(path: Path) -> None:
    """See whether films of the kind that a file's name tells can be written here.

    Raises:
        UsageError: They cannot; the message says which can, or what is missing.
    """
    if path.suffix.lower() not in KINDS:
        raise UsageError(f"'{path}' is no film's name: let it end in {' or '.join(KINDS)}")
    if path.suffix.lower() == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ImportError as error:
            raise UsageError(f"MP4 needs {error.name}: pip install 'fd100-harness[video]', or write a .gif") from error


def write_film(frames: Iterable[Frame], path: Path) -> None:
    """Write a film, in one go: a reader finds the old file or the new one, whole.

    Args:
        frames: Its pictures.
        path: Ends in ``.gif`` or ``.mp4``.

    Raises:
        UsageError: A library is missing, or `path` cannot be written.
    """
    require_kind(path)
    writer = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    try:
        with whole_file(path) as partial:
            writer(list(frames), partial)
    except OSError as error:
        raise UsageError(f"The film '{path}' cannot be written: {error.strerror or error}") from error


def _write_gif(frames: list[Frame], path: Path) -> None:
    from PIL import Image

    frames = [*frames[-1:], *frames[:-1]]
    palette = _palette([frames[0].image, frames[-1].image])
    images = [frame.image.quantize(palette=palette, dither=Image.Dither.NONE) for frame in frames]
    durations = [round(1000 * frame.seconds) for frame in frames]
    images[0].save(path, "GIF", save_all=True, append_images=images[1:], duration=durations, loop=0, optimize=True)


def _palette(images: "list[Image.Image]") -> "Image.Image":
    """The colours that these have most, and those of thin lines, as an image."""
    from PIL import Image, ImageColor

    beside = Image.new("RGB", (sum(image.width for image in images), images[0].height))
    for index, image in enumerate(images):
        beside.paste(image, (index * images[0].width, 0))
    palette = beside.quantize(SHARED)
    lines = [share for colour in LINES for share in ImageColor.getrgb(colour)]
    palette.putpalette([*(palette.getpalette() or [])[: 3 * SHARED], *lines])
    return palette


def _write_mp4(frames: list[Frame], path: Path) -> None:
    import imageio_ffmpeg

    size = frames[0].image.size
    writer = imageio_ffmpeg.write_frames(
        str(path), size, fps=RATE, macro_block_size=2, output_params=["-f", "mp4"], ffmpeg_log_level="error"
    )
    writer.send(None)
    for frame in frames:
        for _ in range(max(1, round(frame.seconds * RATE))):
            writer.send(np.ascontiguousarray(frame.image))
    writer.close()
