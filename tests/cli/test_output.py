"""What the command line writes: hidden characters as escapes, whoever wrote them, in the encoding of the stream."""

import logging
import os
import subprocess
import sys
import threading
import warnings

import pytest

from harness.cli.output import libraries_visible

TINY = (
    *("run", "--sim", "kinematic", "--algo", "random", "--steps", "5", "--seeds", "1"),
    *("--evaluation-episodes", "1", "--jobs", "1", "--out", "mine"),
)


def _answer(encoding, *arguments):
    """What a process leaves whose streams have an encoding."""
    command = [sys.executable, "-m", "harness", *arguments]
    return subprocess.run(command, env={**os.environ, "PYTHONIOENCODING": encoding}, capture_output=True, check=False)


def test_no_character_ends_a_command(tmp_path_factory, subtests):
    """One that the encoding has not is written out, and what is written is in that encoding."""
    for encoding in ["ascii", "latin-1"]:
        for arguments in [("run", "--help"), ("describe",), ("describe", "arp"), TINY]:
            with subtests.test(encoding=encoding, arguments=arguments), pytest.MonkeyPatch.context() as monkeypatch:
                monkeypatch.chdir(tmp_path_factory.mktemp("case"))
                answer = _answer(encoding, *arguments)
                assert (answer.returncode, b"unexpected" in answer.stderr) == (0, False)
                assert answer.stdout.decode(encoding)


def test_the_encoding_stays():
    """A letter that it has is written in it."""
    answer = _answer("latin-1", "report", "Größe")
    assert "'Größe'".encode("latin-1") in answer.stderr


def test_another_way_to_replace_characters_stays():
    """Who asked for question marks gets them."""
    assert b"\\xb7" in _answer("ascii", "audit", "--reward", "arp", "--budget", "0").stdout
    assert b"\\xb7" not in _answer("ascii:replace", "audit", "--reward", "arp", "--budget", "0").stdout


EVIL = "\x1b]0;title\x07\u202e"
SHOWN = "\\x1b]0;title\\x07\\u202e"


def test_what_libraries_say_by_themselves_is_visible(capsys):
    """Warnings, log lines that nobody handles, errors of threads; afterwards all is as before."""
    before = warnings.showwarning, threading.excepthook
    logger = logging.getLogger("harness.tests.nobody")
    handlers, logging.root.handlers = logging.root.handlers, []
    try:
        with libraries_visible(), warnings.catch_warnings():
            warnings.simplefilter("always")
            warnings.showwarning(UserWarning(f"warned {EVIL}"), UserWarning, "a.py", 1)
            logger.warning("logged %s", EVIL)
            _fail_in_thread()
    finally:
        logging.root.handlers = handlers
    assert (warnings.showwarning, threading.excepthook) == before
    told = capsys.readouterr().err
    for text in (f"warned {SHOWN}", f"logged {SHOWN}", f"a thread ended: ValueError: threw {SHOWN}"):
        assert text in told
    assert "\x1b" not in told


def _fail_in_thread():
    def throw():
        raise ValueError(f"threw {EVIL}")

    thread = threading.Thread(target=throw)
    thread.start()
    thread.join()


def test_export_obeys_no_name(harness, finished):
    """A folder with an escape in its name is shown by it."""
    answer = harness("export", finished(1), "--csv", "--out", f"out{EVIL}")
    assert (answer.status, answer.out) == (0, "")
    assert f"out{SHOWN}" in answer.err
    assert "\x1b" not in answer.err


def test_help_obeys_no_plugin(harness, monkeypatch):
    """What a plugin says of itself is text."""
    monkeypatch.setattr("harness.cli.help._first_sentence", lambda command: f"Does {EVIL}.")
    out = harness("--help").out
    assert SHOWN in out
    assert "\x1b" not in out
