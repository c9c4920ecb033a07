"""The examples of docs/audit.md: each is run as it stands there, with fewer steps."""

import re

import pytest

from harness.experiment.screening import CANNOT_TELL, FAILING, LOITERING, NOTHING
from harness.record import read_recording
from tests.project import page_of

PAGE = page_of("audit")
CHEATED, RECORDED, ASKED = re.findall(r"^```python\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
WORDS = (CANNOT_TELL, FAILING, LOITERING, NOTHING)
SHORT = ("gamma=0.99,", "gamma=0.99, episodes=1, steps=30,")


def _run(example):
    exec(compile(example, "example.py", "exec"), {})


def test_random_actions_are_recorded(tmp_path, monkeypatch):
    """Twenty episodes."""
    monkeypatch.chdir(tmp_path)
    _run(RECORDED.replace("episodes=20", "episodes=2"))
    training = read_recording(tmp_path / "random")
    assert (len(training), training.facts.rewards) == (400, ("upright", "own"))


def test_functions_are_compared(capsys):
    """The shaped reward is far in steps, and nowhere else."""
    assert SHORT[0] in ASKED
    _run(ASKED.replace(*SHORT))
    block = capsys.readouterr().out.partition("upright and shaped\n")[2].partition("\n\n")[0]
    assert not block.startswith("distance by steps     0.000")
    for form in ("EPIC", "DARD", "STARC"):
        assert re.search(rf"^{form} distance +0\.000 \[0\.000, 0\.000\]", block, re.MULTILINE)


@pytest.mark.slow
def test_the_page_says_how_far_apart_they_are(capsys):
    """In steps: potential shaping is a quarter."""
    assert "and 0.25 by steps" in PAGE
    _run(ASKED)
    assert "upright and shaped\ndistance by steps     0.25" in capsys.readouterr().out


def test_cheats_are_looked_for(capsys):
    """It prints the answer, and then its word."""
    _run(CHEATED.replace("budget=20_000", "budget=2_000, starts=1"))
    out = capsys.readouterr().out
    assert "What a cheat would do for spin" in out
    assert out.splitlines()[-1] in WORDS
