"""What becomes of errors."""

import subprocess
import sys

import pytest

from harness.cli import app
from harness.cli.help import GONE


@pytest.fixture
def logs(tmp_path, monkeypatch):
    """The folder for temporary files."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    return folder


def broken(args):
    """A program that fails."""
    raise KeyError("\x1b[2Jgone")


def test_what_nobody_foresaw_is_one_line_and_a_log(harness, logs, monkeypatch):
    """The line names the exception and the log, which holds the traceback; the status is that of sysexits.h."""
    monkeypatch.setattr(app, "_run", broken)
    answer = harness("doctor")
    (log,) = logs.glob("harness-*.log")
    assert answer.status == 70
    assert answer.out == ""
    assert len(answer.err.splitlines()) == 1
    assert "KeyError" in answer.err
    assert "\x1b" not in answer.err
    assert str(log) in answer.err
    assert "in broken" in log.read_text()


def test_interruption_before_a_command_runs_is_quiet(harness, monkeypatch):
    """Ctrl-C while plugins are looked for: status 130 and no traceback."""

    def interrupted(args):
        raise KeyboardInterrupt

    monkeypatch.setattr(app, "_run", interrupted)
    answer = harness("doctor")
    assert (answer.status, answer.out, answer.err) == (130, "", "")


def test_where_no_log_can_be_written_the_traceback_is_shown(harness, logs, monkeypatch):
    """Rather that than nothing."""
    monkeypatch.setattr(app, "_run", broken)
    logs.rmdir()
    answer = harness("doctor")
    assert answer.status == 70
    assert "in broken" in answer.err
    assert "KeyError" in answer.err.splitlines()[-1]


def test_what_typer_refuses_names_the_help_with_examples(harness):
    """In the same line."""
    assert harness("report").err == "harness: Missing argument 'DIR...'. Examples: harness report --help\n"
    told = harness("reprot").err
    assert told.endswith("? Examples: harness --help\n")
    assert "Did you mean 'report'" in told


@pytest.mark.parametrize("word", GONE)
def test_a_command_that_is_gone_names_what_takes_its_place(harness, word):
    """In one line, whatever else was typed."""
    answer = harness(word, "--json")
    assert (answer.status, answer.out) == (2, "")
    assert answer.err == f"harness: The command '{word}' is gone: {GONE[word]}. Examples: harness --help\n"


def test_a_long_message_is_cut(harness):
    """To what fits on a screen, its end included."""
    answer = harness("run --seeds", "x" * 13_000)
    assert answer.status == 2
    assert len(answer.err) < 320


def test_what_the_system_refuses_is_one_line(harness, monkeypatch):
    """With the file and what to do."""

    def full(args):
        raise OSError(28, "No space left on device", "page.html")

    monkeypatch.setattr(app, "_run", full)
    answer = harness("doctor")
    assert answer.status == 1
    assert "No space left on device: 'page.html'. Solve that, then run the same command again" in answer.err


def test_reader_that_has_enough_is_no_error():
    """As `head` does, after one line."""
    program = "from harness.cli import main; main(['describe'])"
    with subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, stderr=subprocess.PIPE) as process:
        assert process.stdout is not None
        process.stdout.close()
        assert process.stderr is not None
        assert process.stderr.read() == b""
        assert process.wait() == 1


@pytest.mark.parametrize("name", ["a" * 300, "/".join(["a" * 200] * 30)], ids=["name", "path"])
@pytest.mark.parametrize("command", ["demo --out", "report", "status"], ids=lambda it: it[0])
def test_a_path_that_is_too_long_is_a_usage_error(harness, command, name):
    """Status 2 and one line that says how long it may be."""
    answer = harness(command, name)
    assert (answer.status, answer.out, answer.err.count("\n")) == (2, "", 1)
    assert "255 bytes" in answer.err
