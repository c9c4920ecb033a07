from PIL import Image


def test_a_film_of_the_first_comparison_is_the_default(harness, experiment, tmp_path):
    """Baseline and proposed reward beside one another, in a GIF; standard output stays empty."""
    answer = harness("video mine --episodes 1 --out a.gif")
    assert (answer.status, answer.out) == (0, "")
    assert "Video: a.gif" in answer.err
    with Image.open(tmp_path / "a.gif") as film:
        assert film.width == 360
        assert film.n_frames > 5


def test_named_cells_are_shown(harness, experiment, tmp_path):
    """One cell makes a film of one arm."""
    (cell, *_) = sorted(path.name for path in (tmp_path / "mine" / "cells").iterdir())
    assert harness("video mine --cells", cell, "--episodes", "1", "--out", "a.gif").status == 0
    with Image.open(tmp_path / "a.gif") as film:
        assert film.width == 180
