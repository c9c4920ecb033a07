"""The examples in every help can be typed."""

import shlex

import pytest
import typer

from harness import load_registry
from harness.cli.app import PANELS, build_app
from harness.cli.commands import KIND
from harness.cli.help import EXAMPLES, FIRST_STEPS

LINES = [line for lines in EXAMPLES.values() for line in lines]


def test_every_command_has_examples():
    """And no example is of a command that is gone."""
    assert sorted(EXAMPLES) == sorted({name for names in PANELS.values() for name in names})


def test_example_can_be_typed(subtests):
    """Its command, flags and values are those that there are; nothing is run."""
    for line in [*LINES, *FIRST_STEPS]:
        with subtests.test(line=line):
            program, name, *arguments = shlex.split(line)
            command = typer.main.get_command(build_app()).commands[name]
            assert program == "harness"
            if arguments != ["--help"]:
                command.make_context(name, arguments)


def test_help_shows_the_examples(harness, monkeypatch, subtests):
    """At its end."""
    for name in EXAMPLES:
        with subtests.test(name=name):
            monkeypatch.setenv("COLUMNS", "120")
            out = harness(name, "--help").out
            assert all(line in out for line in EXAMPLES[name])


def test_commands_stand_in_groups_what_one_needs_first_at_the_top(harness):
    """Under headings, and what to type first at the end."""
    out = harness("--all").out
    places = [out.index(text) for text in ("Run and read", " demo ", " run ", "Ask more", " eta ", "First steps:")]
    assert places == sorted(places)


@pytest.mark.parametrize("name", ["audit", "doctor", "watch"])
def test_examples_of_a_command_from_a_plugin_can_be_typed(harness, monkeypatch, name):
    """They stand at the end of its help too."""
    monkeypatch.setenv("COLUMNS", "120")
    function = load_registry().get(KIND, name).load()
    app = typer.Typer(add_completion=False)
    app.command(name)(function)
    out = harness(name, "--help").out
    for line in function.examples:
        assert line in out
        typer.main.get_command(app).make_context(name, shlex.split(line)[2:])
