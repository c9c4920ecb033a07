"""The pictures of a film, and films as files."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from numpy.linalg import norm
from numpy.testing import assert_array_equal
from PIL import Image, ImageColor

from harness.results.replay import Episode, Show, Side
from harness.scene.scene import scene_of
from harness_plugins.video.film import FRAMES, HEIGHT, HELD, LINE, RATE, WIDTH, Frame, film_of, write_film
from tests.refusals import refused
from tests.registered import FD100


def episode(steps, outcome):
    """The FD100 turns by its first joint."""
    qpos = FD100.home + np.linspace(0, 0.5, steps + 1)[:, None] * np.eye(6)[0]
    target = np.tile(FD100.end_effector(qpos[-1]), (steps + 1, 1))
    distance = norm(FD100.end_effector(qpos) - target, axis=1)
    return Episode(np.arange(steps + 1), qpos, target, distance, -distance, outcome, {})


@pytest.fixture(scope="module")
def show():
    """A quick and a slow side, one episode."""
    scene = scene_of(FD100)
    sides = [
        Side(title, (0,), scene, (episode(steps, outcome),), 0.1)
        for title, steps, outcome in (("one", 4, "reached"), ("other", 60, "time-out"))
    ]
    return Show("both", (7,), tuple(sides))


def test_a_film_shows_all_sides_and_holds_the_end(show):
    """Its last picture is seen longest; sides stand beside one another, and fit a phone."""
    frames = list(film_of(show))
    assert 1 < len(frames) <= FRAMES
    assert frames[-1].seconds == HELD
    assert frames[0].image.width == 360
    assert (np.asarray(frames[0].image) != np.asarray(frames[-1].image)).any()


def test_a_side_that_ended_stands_still(show):
    """While the other one goes on."""
    first, last = (np.asarray(frame.image)[LINE : LINE + HEIGHT] for frame in list(film_of(show))[-10:-1:8])
    assert_array_equal(first[:, :WIDTH], last[:, :WIDTH])
    assert (first[:, WIDTH:] != last[:, WIDTH:]).any()


def test_a_third_side_stands_below(show):
    """A film is never wider than two."""
    frame = next(film_of(replace(show, sides=(*show.sides, show.sides[0]))))
    alone = next(film_of(show))
    assert frame.image.width == alone.image.width
    assert frame.image.height == 2 * alone.image.height - LINE


COLOURS = ("#5b6877", "#7a3db8", "#f3f5f7")
PICTURES = [Frame(Image.new("RGB", (32, 20), colour), 0.5) for colour in COLOURS]


def test_a_gif_has_every_picture(tmp_path):
    """Each as long as it is to be seen: first the last one, which tells how it ends, then all others in order."""
    write_film(PICTURES, tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as film:
        assert (film.n_frames, film.size, film.info["duration"]) == (3, (32, 20), 500)
        seen = []
        for number in range(film.n_frames):
            film.seek(number)
            seen.append(film.convert("RGB").getpixel((5, 5)))
    assert seen == [ImageColor.getrgb(colour) for colour in (COLOURS[2], *COLOURS[:2])]


def test_another_ending_is_refused(tmp_path):
    """The message says which there are."""
    with refused(r"\.gif or \.mp4"):
        write_film(PICTURES, tmp_path / "a.avi")


def test_mp4_says_what_to_install(tmp_path, monkeypatch):
    """What writes them comes with the extra video."""
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with refused(r"fd100-harness\[video\]"):
        write_film(PICTURES, tmp_path / "a.mp4")


def test_a_folder_that_is_not_there_is_said_in_one_line(tmp_path):
    """No film, and no traceback."""
    with refused("cannot be written"):
        write_film(PICTURES, tmp_path / "nowhere" / "a.gif")


def test_an_mp4_shows_each_picture_as_long_as_it_is_to_be_seen(tmp_path):
    """In order, at the rate of the film."""
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    write_film(PICTURES, tmp_path / "a.mp4")
    read = [ffmpeg.get_ffmpeg_exe(), "-i", tmp_path / "a.mp4", "-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    raw = subprocess.run(read, capture_output=True, check=True).stdout
    pictures = np.frombuffer(raw, np.uint8).reshape(-1, 20 * 32, 3).mean(axis=1)
    assert len(pictures) == 3 * RATE // 2
    shown = [np.abs(pictures - ImageColor.getrgb(colour)).max(axis=1) < 8 for colour in COLOURS]
    assert np.argmax(shown, axis=0).tolist() == sorted([0, 1, 2] * (RATE // 2))
