"""README.md: one screen that asks the question, shows the answer, and gives two commands to type."""

import json

import pytest

from harness.cli import main
from tests.docs.pages import ROOT, blocks_of, commands_of

README = (ROOT / "README.md").read_text()
COMMANDS = [it.text for block in blocks_of("README.md", README) for it in commands_of(block)]
FIRST_SCREEN = 32
"""Lines of the source that a forge shows on a screen of 900 pixels, with the picture."""


def is_short(text):
    """Whether it has 90 lines at most."""
    return len(text.splitlines()) <= 90


def test_it_is_short():
    """And the check would see a longer one."""
    assert is_short(README)
    assert not is_short(README + "more\n" * 91)


def test_first_screen_has_question_picture_and_two_commands():
    """In this order."""
    first = "\n".join(README.splitlines()[:FIRST_SCREEN])
    places = [first.find(it) for it in ("numbers bigger?**", "](docs/pictures/reach.png)", *COMMANDS[:2])]
    assert -1 not in places
    assert places == sorted(places)


@pytest.mark.parametrize("text", ["make run", "make test", "**the arm**"])
def test_it_has_what_people_look_for(text):
    """Both commands that do everything, and the first of the doors."""
    assert text in README


@pytest.mark.parametrize("index", ["I_N", "I_P", "eta_N", "eta_P"])
def test_it_takes_no_index_to_read_it(index):
    """They are explained elsewhere."""
    assert index not in README


def test_it_tells_the_audit_as_it_is_measured(capsys):
    """By the command that it shows: what creeping earns, and what finishing earns."""
    (command,) = (it for it in COMMANDS if it.startswith("harness audit"))
    with pytest.raises(SystemExit):
        main([*command.split()[1:], "--json"])
    earned = {it["policy"]: it["total"] for it in json.loads(capsys.readouterr().out)["policies"]}
    assert f"gets {earned['creep']:.3g} an episode" in " ".join(README.split())
    assert f"gets {earned['finish']:.3g}." in README
