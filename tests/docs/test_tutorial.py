"""docs/tutorial.md, from its first command to its last, with trainings of 64 steps."""

import pytest

from harness.cli import main
from tests.docs.pages import blocks_of, commands_of
from tests.project import ROOT, page_of

TUTORIAL = page_of("tutorial")
COMMANDS = [it for block in blocks_of("docs/tutorial.md", TUTORIAL) for it in commands_of(block)]
BUDGET = ("--seeds 8", "--steps 64 --seeds 1 --evaluation-episodes 2")


def test_tutorial_names_the_run_whose_pictures_it_shows():
    """As `docs/pictures/take.py` does."""
    told = (ROOT / "docs" / "pictures" / "take.py").read_text()
    runs = [it.text for it in COMMANDS if it.words[0] in {"demo", "run"} and "--dry-run" not in it.words]
    assert len(runs) == 2
    assert all(run in told for run in runs)


@pytest.mark.slow
def test_every_command_of_the_tutorial_runs(tmp_path, monkeypatch):
    """In order, each on what the ones before it left; all pages and pictures that it speaks of are there."""
    monkeypatch.chdir(tmp_path)
    for command in COMMANDS:
        short = command._replace(text=command.text.replace(*BUDGET))
        with pytest.raises(SystemExit) as stopped:
            main(short.words)
        assert stopped.value.code == 0, command.text
    assert len(COMMANDS) == 6
    for folder in ("my-first", "first"):
        page = (tmp_path / folder / "report.html").read_text()
        for text in (">What the robot does<", ">See it<", ">The number<", ">Repeat it<"):
            assert text in page, text
