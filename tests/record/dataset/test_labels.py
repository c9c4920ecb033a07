"""What is a label, and what needs a threshold."""

from pathlib import Path

import numpy as np
import pytest

from harness.errors import UsageError
from harness.record.dataset.labels import FAILURE, SUCCESS, UNKNOWN, SuccessRule, parse_success, read_labels


def test_labels_have_any_type(subtests: pytest.Subtests) -> None:
    """Labels have any type."""
    for kind in [bool, np.uint8, np.int8, np.float16, np.float64]:
        for shape in [(2,), (2, 1)]:
            with subtests.test(kind=kind, shape=shape):
                assert SuccessRule("k").of_steps(np.array([0, 1], kind).reshape(shape), "k").tolist() == [
                    FAILURE,
                    SUCCESS,
                ]


def test_nan_and_minus_one_are_not_known() -> None:
    """NaN and -1 are not known."""
    assert SuccessRule("k").of_steps(np.array([np.nan, -1.0]), "k").tolist() == [UNKNOWN, UNKNOWN]


@pytest.mark.parametrize("value", [0.5, 2.0, np.inf, -2.0])
def test_another_number_is_refused(value: float) -> None:
    """Another number is refused, with what to type."""
    with pytest.raises(UsageError, match=r"--success 'k>0\.5'"):
        SuccessRule("k").of_steps(np.array([0.0, value]), "k")


def test_several_numbers_a_step_are_no_label() -> None:
    """Several numbers a step are no label."""
    with pytest.raises(UsageError, match="2 numbers a step"):
        SuccessRule("k").of_steps(np.zeros((3, 2)), "k")


@pytest.mark.parametrize(
    ("text", "told"),
    [("k>0.5", [0, 0, 1, -1]), ("k>=0.5", [0, 1, 1, -1]), ("k < 0.5", [1, 0, 0, -1]), ("a b/c<=0.5", [1, 1, 0, -1])],
)
def test_a_threshold_makes_labels(text: str, told: list[int]) -> None:
    """A threshold makes labels; NaN stays unknown."""
    assert parse_success(text).of_steps(np.array([0.2, 0.5, 0.7, np.nan]), "k").tolist() == told


def test_a_rule_that_is_none_is_refused(subtests: pytest.Subtests) -> None:
    """A rule that is none is refused."""
    for text in ["k>", "k>x", "k=1", "k>nan", ">1", "k>1>2"]:
        with subtests.test(text=text), pytest.raises(UsageError, match=r"KEY>0\.5"):
            parse_success(text)


def test_an_episode_s_label_may_be_text(subtests: pytest.Subtests) -> None:
    """An episode's label may be text."""
    rows = [
        ("True", 1),
        (b"false", 0),
        ("1.0", 1),
        ("", -1),
        ("nan", -1),
        (None, -1),
        (-1, -1),
        ([True], 1),
        (np.float32(0), 0),
    ]
    for value, told in rows:
        with subtests.test(value=value, told=told):
            assert SuccessRule("k").of_episode(value, "k") == told


@pytest.mark.parametrize("value", ["won", 0.5, [1, 0], "0.5"])
def test_another_value_of_an_episode_is_refused(value: object) -> None:
    """Another value of an episode is refused."""
    with pytest.raises(UsageError, match="label"):
        SuccessRule("k").of_episode(value, "k")


def test_a_file_of_labels_may_have_a_threshold(tmp_path: Path) -> None:
    """A file of labels may have a threshold, and another column."""
    (tmp_path / "l.csv").write_text("episode, score\n0,0.2\n1,0.7\n2,\n")
    assert read_labels(tmp_path / "l.csv", parse_success("score>0.5")) == {0: FAILURE, 1: SUCCESS, 2: UNKNOWN}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("number,success\n0,1\n", "it needs episode and success"),
        ("episode,success\nx,1\n", "line 2: 'x' is no number of an episode"),
        ("episode,success\n0,1\n0,0\n", "line 3: episode 0 has another label above"),
        ("episode,success\n0,0.5\n", "line 2 holds 0.5, which is no label"),
        ("", "none; it needs episode"),
    ],
)
def test_a_file_of_labels_that_is_none_is_one_line(tmp_path: Path, text: str, told: str) -> None:
    """A file of labels that is none is one line."""
    (tmp_path / "l.csv").write_text(text)
    with pytest.raises(UsageError, match=told):
        read_labels(tmp_path / "l.csv", SuccessRule())


def test_a_file_of_labels_that_is_not_there_is_one_line(tmp_path: Path) -> None:
    """A file of labels that is not there is one line."""
    with pytest.raises(UsageError, match="cannot be read"):
        read_labels(tmp_path / "l.csv", SuccessRule())


def test_a_file_of_labels_may_be_spelled_otherwise(
    tmp_path_factory: pytest.TempPathFactory, subtests: pytest.Subtests
) -> None:
    """Capitals, LeRobot's own name, quotes, and what pandas makes of a whole number."""
    for header in ["Episode,Success", "episode_index,success", ' episode , "success" ']:
        for number in ["1", "1.0", '"1"']:
            with subtests.test(header=header, number=number):
                tmp_path = tmp_path_factory.mktemp("case")
                (tmp_path / "l.csv").write_bytes(f"{header}\r\n0,False\r\n{number}, True \r\n".encode())
                assert read_labels(tmp_path / "l.csv", SuccessRule()) == {0: FAILURE, 1: SUCCESS}


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("episode,success\n0,0,9\n", "line 2 has other cells than the header"),
        ("episode,success\n0\n", "line 2 has other cells than the header"),
        ("episode,success,success\n0,1,0\n", "once each"),
        ("episode;success\n0;1\n", "no commas but ';'"),
        ("episode,success\n0,yes\n", "line 2 says 'yes': 0, 1, false and true are labels"),
    ],
)
def test_a_file_of_labels_with_other_cells_is_refused(tmp_path: Path, text: str, told: str) -> None:
    """A decimal comma, a cell that is missing, or a second column would be a wrong label."""
    (tmp_path / "l.csv").write_text(text)
    with pytest.raises(UsageError, match=told):
        read_labels(tmp_path / "l.csv", SuccessRule())
