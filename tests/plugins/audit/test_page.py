"""The examples of docs/audit.md: each is run as it stands there, with fewer steps."""

import re
from pathlib import Path

import pytest

from harness.record.recording.recorded_training import read_recording

PAGE = (Path(__file__).parents[3] / "docs" / "audit.md").read_text(encoding="utf-8")
RECORDED, ASKED = re.findall(r"^```python\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
SHORT = ("gamma=0.99,", "gamma=0.99, episodes=1, steps=30,")


def _run(example: str) -> None:
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
def test_the_page_shows_what_is_printed(capsys):
    """Line by line."""
    (shown,) = re.findall(r"^A part of what it prints:\n\n```\n(.*?)^```", PAGE, re.DOTALL | re.MULTILINE)
    _run(ASKED)
    assert shown in capsys.readouterr().out
