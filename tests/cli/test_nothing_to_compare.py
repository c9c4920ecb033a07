"""``harness run`` with one reward alone: refused before anything is trained."""

import pytest

ALONE = ("run", "--task", "gymnasium:id=CartPole-v1", "--algo", "random", "--steps", "40", "--seeds", "1")
SHORT = (*ALONE, "--evaluation-episodes", "1", "--executor", "here", "--out", "mine")
OWN = "def other(observation, action, next_observation, info):\n    return 0.5\n"


@pytest.mark.parametrize("flags", [(), ("--dry-run",), ("--reward", "own")])
def test_one_reward_alone_is_refused(harness, tmp_path, flags):
    """Status 2, one line with what to type instead, and no folder."""
    answer = harness(*SHORT, *flags)
    assert (answer.status, answer.out) == (2, "")
    assert "Nothing to compare: everything would be trained with the reward 'own'." in answer.err
    assert "--reward own,own" in answer.err
    assert list(tmp_path.iterdir()) == []


def test_the_same_reward_twice_is_a_null_control(harness):
    """It is compared with itself."""
    assert harness(*SHORT, "--reward", "own,own").status == 0


def test_what_the_folder_holds_counts(harness, tmp_path):
    """One reward alone joins another that was trained there before."""
    (tmp_path / "other.py").write_text(OWN)
    assert harness(*SHORT, "--plugin", "other.py", "--reward", "own,other").status == 0
    assert harness(*SHORT, "--reward", "own", "--seeds", "2").status == 0
