"""``harness demo`` as a newcomer types it."""

import subprocess
import sys

from harness.results import load_results


def test_the_number_grows_and_the_arm_moves_the_same(harness, tmp_path):
    """Every recorded step is alike, eta_P is 1.5, all of it is ruler; the experiment stays where it was told to."""
    answer = harness("demo", "--out", "mine")
    assert (answer.status, answer.err) == (0, "")
    told = " ".join(answer.out.split())
    assert "comes out at 1.50" in told
    same, recorded = told.partition("In ")[2].partition(" recorded")[0].split(" of ")
    assert same == recorded != "0"
    (combination,) = load_results(tmp_path / "mine").combinations
    split = combination.splits["eta_P"]
    assert (round(split.ruler.value, 9), round(split.behaviour.value, 9)) == (1.5, 1.0)
    assert "harness report mine --details" in answer.out


def test_a_folder_with_something_in_it_is_left_alone(harness, tmp_path):
    """Status 2 and one line."""
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "thesis.txt").write_text("all of it")
    answer = harness("demo", "--out", "mine")
    assert (answer.status, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert "--out 'mine' is not empty: name a new or empty folder" in answer.err
    assert [path.name for path in (tmp_path / "mine").iterdir()] == ["thesis.txt"]


def test_python_m_harness_is_the_command_line():
    """For who has no scripts on the path."""
    told = subprocess.run([sys.executable, "-m", "harness", "--version"], capture_output=True, text=True, check=True)
    assert told.stdout.count(".") == 2
