"""Commands that plugins bring: listed by name and summary, imported when they are called."""

import sys
from pathlib import Path

import pytest

COMMAND = """
import typer
from harness.errors import UsageError

def wave(times: int = 1, name: str = typer.Argument("all")) -> int | None:
    "Wave an arm at someone."
    if times < 0:
        raise UsageError("no arm waves less than not at all")
    if times > 9:
        raise typer.Exit(4)
    print(f"waves {times} times at {name}")
"""


@pytest.fixture
def add_commands(install):
    """Install a package that registers a command under each of these names."""

    def add(*names, package="waving", target="wave"):
        lines = [f"    register({name!r}, __name__ + '_command:{target}', summary='waves an arm')\n" for name in names]
        hook = "import harness\n@harness.hookimpl\ndef register_commands(register):\n"
        install(package, hook + "".join(lines), command=COMMAND)

    return add


def _imported():
    return [name for name in sys.modules if name.startswith("waving") and name.endswith("_command")]


def test_help_shows_the_summary_and_imports_nothing(harness, add_commands):
    """The target of a command is not imported to list it."""
    before = _imported()
    add_commands("wave")
    assert "waves an arm" in harness("--all").out
    assert "waves an arm" in harness("describe commands").out
    assert _imported() == before


def test_command_gets_its_arguments(harness, add_commands):
    """Options and arguments reach the function, by their types."""
    add_commands("wave")
    assert harness("wave --times 3 you") == (0, "waves 3 times at you\n", "")


def test_command_explains_itself(harness, add_commands):
    """`--help` behind the name is the function's own."""
    add_commands("wave")
    out = harness("wave --help").out
    assert "Usage: harness wave" in out
    assert "--times" in out


@pytest.mark.parametrize(
    ("arguments", "status", "told"),
    [
        ("--times -1", 2, "harness: no arm waves less than not at all\n"),
        ("--times often", 2, "Invalid value for '--times'"),
        ("--loudly", 2, "No such option: --loudly"),
        ("--times 10", 4, ""),
    ],
)
def test_errors_and_status_come_through(harness, add_commands, arguments, status, told):
    """As those of our own commands, in one line."""
    add_commands("wave")
    answer = harness(f"wave {arguments}")
    assert answer.status == status
    assert told in answer.err
    assert answer.err.count("\n") == bool(told)


def test_command_that_cannot_be_imported_names_its_plugin(harness, add_commands):
    """And breaks no other."""
    add_commands("wave", target="no_such_function")
    answer = harness("wave")
    assert answer.status == 1
    assert "Plugin 'waving' (waving 1.0)" in answer.err
    assert harness("describe commands").status == 0


def test_command_of_two_plugins_names_both(harness, add_commands):
    """Neither is called."""
    add_commands("wave")
    add_commands("wave", package="waving_too")
    answer = harness("wave")
    assert answer.status == 1
    assert (
        "Command 'wave' is claimed by the plugins 'waving' (waving 1.0) and 'waving_too' (waving_too 1.0)" in answer.err
    )


def test_our_own_command_is_not_replaced(harness, add_commands, rendering):
    """A plugin's command of the same name is hidden, and `doctor` says so."""
    rendering("true")
    add_commands("eta", "wave")
    hidden = (
        "Command 'eta' of the plugin 'waving' (waving 1.0) is hidden by a built-in command: type harness waving/eta"
    )
    assert "recorded" in harness("eta --help").out
    assert hidden in harness("doctor").out
    assert harness("wave").status == 0
    assert harness("waving/eta").out == "waves 1 times at all\n"


def test_command_is_described(harness, add_commands):
    """`harness describe` knows whatever `harness describe` shows."""
    add_commands("wave")
    assert harness("describe wave").out == "command wave: waves an arm (plugin 'waving' of waving 1.0)\n"


def test_unknown_command_offers_those_of_plugins(harness, add_commands):
    """The nearest match may be a plugin's."""
    add_commands("wave")
    assert "Did you mean 'wave'" in harness("wav").err


def test_folder_stays_empty(harness, add_commands):
    """Listing and calling leave nothing behind."""
    add_commands("wave")
    harness("--help")
    harness("wave")
    assert list(Path().iterdir()) == []


def test_bare_harness_shows_the_help_and_says_no_more(harness):
    """The help, with the status that typer gives it, and nothing on standard error."""
    bare = harness()
    assert (bare.status, bare.err) == (2, "")
    assert bare.out.rstrip() == harness("--help").out.rstrip()
    assert "Usage: harness" in bare.out


def test_our_commands_import_no_foreign_plugin(harness, install):
    """One that cannot be imported is no trouble of theirs; a command that cannot be is listed, as any foreign one."""
    raising = "raise SystemExit('no licence')\n"
    hook = "import harness\n@harness.hookimpl\ndef register_commands(register):\n"
    line = "    register('nod', __name__ + '_command:nod', summary='nods to someone')\n"
    foreign = {install("no-licence", raising), install("nodding", hook + line, command=raising)}
    answer = harness("check --help")
    assert (answer.status, answer.err) == (0, "")
    assert "Usage: harness check" in answer.out
    assert not foreign & set(sys.modules)
    listed = harness("--all")
    assert (listed.status, "nods to someone" in listed.out) == (0, True)
    assert foreign & set(sys.modules)
