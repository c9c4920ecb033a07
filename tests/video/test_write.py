"""Films as files."""

import sys
from pathlib import Path

import pytest
from PIL import Image

from harness.errors import UsageError
from harness.video.film import Frame
from harness.video.write import write_film

PICTURES = [Frame(Image.new("RGB", (32, 20), colour), 0.5) for colour in ("#0072b2", "#d55e00", "#f3f5f7")]


def test_a_gif_has_every_picture(tmp_path: Path):
    """In order, each as long as it is to be seen."""
    write_film(PICTURES, tmp_path / "a.gif")
    with Image.open(tmp_path / "a.gif") as film:
        assert (film.n_frames, film.size, film.info["duration"]) == (3, (32, 20), 500)
        film.seek(1)
        assert film.convert("RGB").getpixel((5, 5)) == (0xD5, 0x5E, 0x00)


def test_another_ending_is_refused(tmp_path: Path):
    """The message says which there are."""
    with pytest.raises(UsageError, match=r"\.gif or \.mp4"):
        write_film(PICTURES, tmp_path / "a.avi")


def test_mp4_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """What writes them comes with the extra video."""
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(UsageError, match=r"fd100-harness\[video\]"):
        write_film(PICTURES, tmp_path / "a.mp4")


def test_a_folder_that_is_not_there_is_said_in_one_line(tmp_path: Path):
    """No film, and no traceback."""
    with pytest.raises(UsageError, match="cannot be written"):
        write_film(PICTURES, tmp_path / "nowhere" / "a.gif")
