"""What is a label, and what needs a threshold."""

import numpy as np
import pytest

from harness.errors import UsageError
from harness.record.dataset.labels import parse_success, read_labels


@pytest.mark.parametrize("kind", [bool, np.uint8, np.int8, np.float16, np.float64])
@pytest.mark.parametrize("shape", [(2,), (2, 1)])
def test_labels_have_any_type(kind, shape):
    """Labels have any type."""
    assert parse_success("k").of_steps(np.array([0, 1], kind).reshape(shape), "k").tolist() == [0, 1]


def test_nan_and_minus_one_are_not_known():
    """NaN and -1 are not known."""
    assert parse_success("k").of_steps(np.array([np.nan, -1.0]), "k").tolist() == [-1, -1]


@pytest.mark.parametrize(
    ("values", "told"),
    [
        *(([0.0, value], r"--success 'k>0\.5'") for value in (0.5, 2.0, np.inf, -2.0)),
        (np.zeros((3, 2)), "2 numbers a step"),
    ],
)
def test_another_number_is_refused(values, told):
    """With what to type; several a step are no label."""
    with pytest.raises(UsageError, match=told):
        parse_success("k").of_steps(np.asarray(values), "k")


@pytest.mark.parametrize(
    ("text", "told"),
    [("k>0.5", [0, 0, 1, -1]), ("k>=0.5", [0, 1, 1, -1]), ("k < 0.5", [1, 0, 0, -1]), ("a b/c<=0.5", [1, 1, 0, -1])],
)
def test_a_threshold_makes_labels(text, told):
    """A threshold makes labels; NaN stays unknown."""
    assert parse_success(text).of_steps(np.array([0.2, 0.5, 0.7, np.nan]), "k").tolist() == told


@pytest.mark.parametrize("text", ["k>", "k>x", "k=1", "k>nan", ">1", "k>1>2"])
def test_a_rule_that_is_none_is_refused(text):
    """A rule that is none is refused."""
    with pytest.raises(UsageError, match=r"KEY>0\.5"):
        parse_success(text)


@pytest.mark.parametrize(
    ("value", "told"),
    [
        *(("True", 1), (b"false", 0), ("1.0", 1), ("", -1), ("nan", -1)),
        *((None, -1), (-1, -1), ([True], 1), (np.float32(0), 0)),
    ],
)
def test_an_episode_s_label_may_be_text(value, told):
    """An episode's label may be text."""
    assert parse_success("k").of_episode(value, "k") == told


@pytest.mark.parametrize("value", ["won", 0.5, [1, 0], "0.5"])
def test_another_value_of_an_episode_is_refused(value):
    """Another value of an episode is refused."""
    with pytest.raises(UsageError, match="label"):
        parse_success("k").of_episode(value, "k")


def test_a_file_of_labels_may_have_a_threshold(tmp_path):
    """A file of labels may have a threshold, and another column."""
    (tmp_path / "l.csv").write_text("episode, score\n0,0.2\n1,0.7\n2,\n")
    assert read_labels(tmp_path / "l.csv", parse_success("score>0.5")) == {"": {0: 0, 1: 1, 2: -1}}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("number,success\n0,1\n", "it needs episode and success"),
        ("episode,success\nx,1\n", "line 2: 'x' is no number of an episode"),
        ("episode,success\n0,1\n0,0\n", "line 3: episode 0 has another label above"),
        ("episode,success\n0,0.5\n", "line 2 holds 0.5, which is no label"),
        ("", "has no header"),
        ("episode,success\n0,0,9\n", "line 2: it has 3 cells, and there are 2 columns"),
        ("episode,success\n0\n", "line 2: it has 1 cells, and there are 2 columns"),
        ("episode,success,success\n0,1,0\n", "names a column twice"),
        ("episode,Episode,success\n0,1,0\n", "once each"),
        ("episode,success\n0,yes\n", "line 2 says 'yes': 0, 1, false and true are labels"),
        (None, "is no readable table: there is no such file"),
    ],
)
def test_a_file_of_labels_that_is_none_is_one_line(tmp_path, text, told):
    """A decimal comma, a cell that is missing, or a second column would be a wrong label."""
    if text is not None:
        (tmp_path / "l.csv").write_text(text)
    with pytest.raises(UsageError, match=told):
        read_labels(tmp_path / "l.csv", parse_success(""))


@pytest.mark.parametrize("header", ["Episode,Success", "episode_index,success", ' episode , "success" '])
@pytest.mark.parametrize("number", ["1", "1.0", '"1"'])
def test_a_file_of_labels_may_be_spelled_otherwise(tmp_path, header, number):
    """Capitals, LeRobot's own name, quotes, and what pandas makes of a whole number."""
    (tmp_path / "l.csv").write_bytes(f"{header}\r\n0,False\r\n{number}, True \r\n".encode())
    assert read_labels(tmp_path / "l.csv", parse_success("")) == {"": {0: 0, 1: 1}}
