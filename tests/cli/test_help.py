"""The help of all commands: short, and whole on demand."""

import re

import pytest
import typer

from harness.cli.app import PANELS, build_app
from harness.cli.help import FIRST, GROUPS, OTHER_COMMANDS, OTHER_FLAGS, TYPED


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


@pytest.mark.parametrize(
    ("typed", "meant"),
    [
        ("run --workers 2", "--jobs"),
        ("run --sedes 3", "--seeds"),
        ("run --algorithm sac", "--algo"),
        ("run --total-timesteps 9", "--steps"),
        ("run -o here", "--out"),
        ("choose --env toy", "--task"),
        ("train --sim ideal", "run"),
        ("list-envs", "describe"),
        ("rn", "run"),
    ],
)
def test_a_near_miss_is_answered_with_what_is_meant(harness, typed, meant):
    """By the words of other tools first, then by likeness: one line."""
    answer = harness(*typed.split())
    assert answer.status == 2
    assert f"Did you mean '{meant}'? Examples: " in answer.err
    assert answer.err.count("\n") == 1


def test_a_seed_is_told_what_seeds_mean(harness):
    """A number of them; one alone has a comma."""
    assert "--seeds 3 trains the seeds 0, 1 and 2; --seeds 3, trains seed 3 alone. " in harness("run --seed 3").err
    told = harness("run --sim kinematic --algo random --seeds 3, --out it --dry-run").out
    assert [line for line in told.splitlines() if line.startswith("to do")] != []
    assert "seed 3" in told
    assert "seed 0" not in told


def test_nothing_is_guessed_where_there_is_no_such_flag(harness):
    """Choosing has no number of seeds, and a status no jobs."""
    assert harness("choose --seed 3").err == "harness: No such option: --seed. Examples: harness choose --help\n"
    assert "Did you mean" not in harness("status --workers 3").err


def test_words_of_other_tools_lead_to_words_of_ours():
    """Each to one, and none is a word of ours."""
    commands = typer.main.get_command(build_app()).commands
    flags = {flag for parameter in commands["run"].params for flag in parameter.opts}
    given = [word for words in OTHER_FLAGS.values() for word in words]
    assert {*OTHER_FLAGS} <= flags
    assert {*OTHER_COMMANDS} <= {*commands, "watch"}
    assert len(given) == len({*given})
    assert not flags & {*given}
