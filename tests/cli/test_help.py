"""The help of all commands: short, and whole on demand."""

import re

import pytest
import typer

from harness.cli.app import PANELS, build_app
from harness.cli.help import FIRST, GROUPS, TYPED


@pytest.fixture
def lines(harness, monkeypatch):
    """The lines of a help in a terminal of 80 columns."""
    monkeypatch.setenv("COLUMNS", "80")
    return lambda *asked: harness(*asked).out.splitlines()


def names(lines):
    """What stands first in each row."""
    return re.findall(r"^  (-*[a-z][a-z-]+)(?: \S+)?  ", "\n".join(lines), re.MULTILINE)


def test_short_help_fits_on_a_screen(lines):
    """24 lines of 80 columns: ten commands, in order, and where the others are."""
    shown = lines("--help")
    assert len(shown) <= 24
    assert max(map(len, shown)) <= 80
    assert names(shown)[: len(FIRST)] == list(FIRST)
    assert any("--all" in line for line in shown)


@pytest.mark.parametrize("asked", [("--all",), ("--help", "--all"), ("--all", "--help")])
def test_all_shows_every_command(lines, asked):
    """Ours, and those that plugins bring; in any order of the flags."""
    shown = names(lines(*asked))
    assert {name for commands in PANELS.values() for name in commands} | {"export"} <= {*shown}


@pytest.mark.parametrize("command", ["run", "choose"])
def test_help_of_a_long_command_shows_what_people_type(lines, command):
    """On 40 lines, with the flag that shows the others."""
    shown = lines(command, "--help")
    assert len(shown) <= 40
    wanted = {f"--{name.replace('_', '-')}" for name in TYPED}
    assert {*names(shown)} - {"experiment"} <= wanted | {"--help", "--help-all", "--looks"}
    assert "--help-all" in names(shown)


def test_help_of_run_shows_twelve(lines):
    """No more, no fewer."""
    wanted = {f"--{name.replace('_', '-')}" for name in TYPED}
    assert {*names(lines("run", "--help"))} == wanted | {"--help", "--help-all"}
    assert len(TYPED) == 12


@pytest.mark.parametrize("command", ["run", "choose"])
def test_help_all_shows_every_option_once(lines, command):
    """Each that the command has, under one heading; a new one that nobody put under a heading is found here."""
    options = typer.main.get_command(build_app(command)).commands[command].params
    asked = {it.name for it in options if it.param_type_name == "option"} - {"help_all"}
    grouped = [name for group in (TYPED, *GROUPS.values()) for name in group]
    assert len(grouped) == len({*grouped})
    assert asked <= {*grouped}
    text = "\n".join(lines(command, "--help-all"))
    assert all(len(re.findall(rf"^  {re.escape(it.opts[0])}\b(?!-)", text, re.MULTILINE)) == 1 for it in options[1:])


@pytest.mark.parametrize("command", [*(it for names in PANELS.values() for it in names), "audit", "doctor", "watch"])
def test_no_flag_has_a_type_of_python(lines, command):
    """`<bool>` tells nobody anything."""
    assert "<bool>" not in "\n".join(lines(command, "--help"))
