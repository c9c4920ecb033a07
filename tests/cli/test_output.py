"""What the command line writes where standard output is not UTF-8."""

import os
import subprocess
import sys

import pytest

TINY = (
    *("run", "--sim", "kinematic", "--algo", "random", "--steps", "5", "--seeds", "1"),
    *("--evaluation-episodes", "1", "--jobs", "1", "--out", "mine"),
)


def _answer(encoding: str, *arguments: str) -> subprocess.CompletedProcess[bytes]:
    """What a process leaves whose streams have an encoding."""
    command = [sys.executable, "-m", "harness", *arguments]
    environment = {**os.environ, "PYTHONIOENCODING": encoding}
    return subprocess.run(command, env=environment, capture_output=True, check=False)


@pytest.mark.parametrize("encoding", ["ascii", "latin-1"])
@pytest.mark.parametrize("arguments", [("run", "--help"), ("list",), ("describe", "arp"), TINY], ids=lambda it: it[0])
def test_no_character_ends_a_command(encoding: str, arguments: tuple[str, ...], tmp_path, monkeypatch):
    """One that the encoding has not is written out, and what is written is in that encoding."""
    monkeypatch.chdir(tmp_path)
    answer = _answer(encoding, *arguments)
    assert (answer.returncode, b"unexpected" in answer.stderr) == (0, False)
    assert answer.stdout.decode(encoding)


def test_the_encoding_stays():
    """A letter that it has is written in it."""
    answer = _answer("latin-1", "report", "Größe")
    assert "'Größe'".encode("latin-1") in answer.stderr


def test_another_way_to_replace_characters_stays():
    """Who asked for question marks gets them."""
    assert b"\\xb7" in _answer("ascii", "audit", "--reward", "arp").stdout
    assert b"\\xb7" not in _answer("ascii:replace", "audit", "--reward", "arp").stdout
