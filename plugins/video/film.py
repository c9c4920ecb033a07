"""The pictures of a film of recorded episodes, and films as files: GIF by pillow, MP4 by ffmpeg.

A GIF begins with its last picture, which is how the last episode ended: where only one picture of it is seen, it is
this one.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from harness import Float
from harness.errors import UsageError
from harness.files.bounded import whole_file
from harness.record.scene import Scene
from harness.registry.spec import require_pillow
from harness.report.figures.chart import SIDES, light_colours
from harness.results.replay import Episode, Show, Side
from harness.robot.kinematics import end_effector_position
from harness.scene.picture import BACKGROUND, TARGET, Camera, camera_for, chain_of, corners_of, draw_arm
from harness.text import visible

if TYPE_CHECKING:
    from PIL import Image, ImageDraw, ImageFont

LIGHT = light_colours()
INK = LIGHT["ink"]
COLOURS = tuple(LIGHT[name] for name in SIDES)
"""The colours of the sides, as on the page."""
WIDTH, HEIGHT, LINE, LETTERS = 180, 190, 18, 12
"""The size of one side's picture, of a line of text and of its letters, in pixels. A phone shows two sides whole."""
COLUMNS = 2
"""How many sides stand beside one another; others stand below."""
APART = "   "
"""What stands between two things that are told; each gets a line."""
TOLD = 2
"""The lines below a picture."""
FRAMES, FEWEST, PER_STEP = 36, 16, 5
"""The frames of an episode: at most, at least, and for each step of a short one."""
RATE = 12
"""Frames per second."""
HELD = 1.0
"""How long the end of an episode is held, [s]."""


@dataclass(frozen=True)
class Frame:
    """One picture of a film, and how long it is seen, [s]."""

    image: "Image.Image"
    seconds: float


def film_of(show: Show) -> Iterator[Frame]:
    """All episodes of a show, one after the other; the typical pair last, so that a GIF begins with its end.

    An episode takes three seconds at most. In a longer one steps pass the faster the later they are, so that one sees
    how the arm gets to its target, and whether it stays away.

    Raises:
        UsageError: pillow is missing.
    """
    require_pillow()
    shares = {(it.seed, it.number + 1): f"{show.pairs.share(it.kind)}\n" for it in show.pairs.met} if show.pairs else {}
    for place in sorted(range(len(show.numbers)), key=lambda it: (bool(show.pairs) and it == show.first, it)):
        number, episodes = show.numbers[place], tuple(side.episodes[place] for side in show.sides)
        share = shares.get((show.sides[0].seeds[place], number), "")
        ways = [_way(side.scene, episode.qpos) for side, episode in zip(show.sides, episodes, strict=True)]
        camera = _camera(ways, episodes, show)
        last = max(int(episode.steps[-1]) for episode in episodes)
        steps = clock_of(last)
        for step in steps:
            views = [
                _view(side, episode, way, camera, step, COLOURS[index % len(COLOURS)])
                for index, (side, episode, way) in enumerate(zip(show.sides, episodes, ways, strict=True))
            ]
            yield frame_of(views, f"{share}episode {number}, step {step:.0f} of {last}", step == steps[-1])


def clock_of(last: int) -> Float:
    """The step that each frame of an episode of `last` steps shows."""
    count = int(np.clip(PER_STEP * last, FEWEST, FRAMES))
    power = 1 if last <= count else 2
    return last * np.linspace(0.0, 1.0, count) ** power


def _way(scene: Scene, qpos: Float) -> Float:
    """Where the end effector is at each row, (rows, 3), [m]."""
    return end_effector_position(chain_of(scene), qpos)


def _camera(ways: list[Float], episodes: tuple[Episode, ...], show: Show) -> Camera:
    corners = np.concatenate(
        [
            corners_of(side.scene, episode.qpos[row])[0]
            for side, episode in zip(show.sides, episodes, strict=True)
            for row in (0, -1)
        ]
    )
    points = np.concatenate([*ways, *(episode.target for episode in episodes), corners.reshape(-1, 3)])
    return camera_for(points, WIDTH, HEIGHT)


def _view(side: Side, episode: Episode, way: Float, camera: Camera, step: float, colour: str) -> "Image.Image":
    """One side at a moment, with its title and what is measured."""
    at = float(np.interp(step, episode.steps, np.arange(len(episode.steps))))
    qpos = np.array([np.interp(step, episode.steps, column) for column in episode.qpos.T])
    row = round(at)
    path = np.vstack([way[: int(at) + 1], _way(side.scene, qpos)])
    measured = f"{side.error} {episode.distance[row]:.3f} {side.unit}".rstrip()
    outcome = episode.outcome if step >= episode.steps[-1] else ""
    picture = draw_arm(side.scene, qpos, episode.target[row], path, colour, camera)
    return view_of(picture, side.title, f"{measured}{APART}paid {episode.paid[row]:.2f}", colour, outcome)


def view_of(picture: "Image.Image", title: str, told: str, colour: str, outcome: str) -> "Image.Image":
    """A side: its picture, WIDTH x HEIGHT; its title above, what is measured below, and how it ended, if it did."""
    from PIL import Image, ImageDraw

    image = Image.new("RGB", (WIDTH, HEIGHT + (1 + TOLD) * LINE), BACKGROUND)
    image.paste(picture, (0, LINE))
    pen = ImageDraw.Draw(image)
    pen.rectangle((0, 3, 4, LINE - 3), fill=colour)
    _write(pen, (10, 2), title, INK)
    first, *others = told.split(APART)
    for line, text in enumerate((first, APART.join(others))):
        _write(pen, (10, HEIGHT + (1 + line) * LINE), text, INK)
    if outcome:
        half = pen.textlength(outcome, _letters()) / 2 + 6
        middle, top = WIDTH - 6 - half, LINE + 4
        pen.rectangle((middle - half, top, middle + half, top + LINE), BACKGROUND, colour, 2)
        _write(pen, (middle, top + 3), outcome, colour, "ma")
    return image


def frame_of(views: list["Image.Image"], caption: str, is_last: bool) -> Frame:
    """All sides, two in a row, with the lines of a caption below; an episode's last frame is held."""
    from PIL import Image, ImageDraw

    rows, high, lines = -(-len(views) // COLUMNS), views[0].height, caption.split("\n")
    whole = Image.new("RGB", (WIDTH * min(COLUMNS, len(views)), rows * high + len(lines) * LINE), BACKGROUND)
    for index, view in enumerate(views):
        whole.paste(view, (WIDTH * (index % COLUMNS), high * (index // COLUMNS)))
    for line, text in enumerate(lines):
        _write(ImageDraw.Draw(whole), (10, rows * high + line * LINE), text, INK)
    return Frame(whole, HELD if is_last else 1 / RATE)


def _write(pen: "ImageDraw.ImageDraw", at: tuple[float, float], text: str, colour: str, anchor: str = "la") -> None:
    pen.text(at, visible(text), colour, _letters(), anchor)


@cache
def _letters() -> "ImageFont.FreeTypeFont | ImageFont.ImageFont":
    from PIL import ImageFont

    return ImageFont.load_default(LETTERS)


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
