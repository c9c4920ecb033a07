import pytest
from PIL import Image


@pytest.fixture
def experiment(finished):
    """A finished experiment."""
    return finished(seeds=1)


def test_a_film_of_the_first_comparison_is_the_default(harness, experiment, tmp_path):
    """Baseline and proposed reward beside one another, in a GIF; standard output stays empty."""
    answer = harness("video", experiment, "--episodes", "1", "--out", "a.gif")
    assert (answer.status, answer.out) == (0, "")
    assert "Video: a.gif" in answer.err
    with Image.open(tmp_path / "a.gif") as film:
        assert film.width == 360
        assert film.n_frames > 5


def test_named_cells_are_shown(harness, experiment, tmp_path):
    """One cell makes a film of one arm."""
    (cell, *_) = sorted(path.name for path in (tmp_path / experiment / "cells").iterdir())
    assert harness("video", experiment, "--cells", cell, "--episodes", "1", "--out", "a.gif").status == 0
    with Image.open(tmp_path / "a.gif") as film:
        assert film.width == 180


@pytest.mark.parametrize(
    ("flags", "problem"),
    [(("--cells", "zz"), "none of the done cells have an id that begins so"), (("--out", "a.webm"), ".gif or .mp4")],
)
def test_what_cannot_be_filmed_is_refused(harness, experiment, flags, problem):
    """One line, status 2."""
    answer = harness("video", experiment, *flags)
    assert (answer.status, answer.err.count("\n")) == (2, 1)
    assert problem in answer.err
