"""Commands that only look: what they open to be written, make, move or remove."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import harness
from tests.left import files_of

LISTEN = """
import json, os, sys
heard = []
CHANGES = ("os.mkdir", "os.rename", "os.remove", "os.rmdir", "os.link", "os.symlink", "os.truncate", "os.chmod")

def listen(event, given):
    if event == "open" and isinstance(given[0], (str, bytes)):
        writes = isinstance(given[1], str) and set(given[1]) & set("wax+")
        if writes or (given[2] or 0) & (os.O_WRONLY | os.O_RDWR | os.O_CREAT | os.O_TRUNC | os.O_APPEND):
            heard.append([event, os.path.abspath(os.fsdecode(given[0]))])
    elif event in CHANGES:
        heard.append([event, os.path.abspath(os.fsdecode(given[0]))])

sys.addaudithook(listen)
from harness.cli.app import main
status = 0
try:
    main(sys.argv[1:])
except SystemExit as ended:
    status = ended.code
print(json.dumps({"status": status, "heard": heard}), file=sys.stderr)
"""


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    """An experiment of two cells."""
    folder = tmp_path_factory.mktemp("ran") / "it"
    harness.run(
        sim="kinematic", algo="random", reward="dense", seeds=1, steps=20, evaluation_episodes=1, jobs=1, out=folder
    )
    return folder


def changes(folder, *words):
    """What a command does to files in the folder, below it, or where links in it lead."""
    environment = {**os.environ, "PYTHONDONTWRITEBYTECODE": "1"}
    command = [sys.executable, "-c", LISTEN, *words]
    ended = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    told = json.loads(ended.stderr.splitlines()[-1])
    assert told["status"] in (0, None), ended.stderr
    return [
        f"{event} {Path(path).relative_to(folder)}" for event, path in told["heard"] if path.startswith(str(folder))
    ]


@pytest.mark.parametrize("words", [("status",), ("status", "--json"), ("verify",), ("verify", "--json")])
def test_looking_writes_nothing(ran, words):
    """Also where the folder has the lock of a run."""
    assert (ran / ".lock").is_file()
    assert changes(ran, words[0], str(ran), *words[1:]) == []


def test_a_report_writes_what_it_keeps_alone(ran, tmp_path):
    """Below the folder for that."""
    shutil.copytree(ran, tmp_path / "it", ignore=shutil.ignore_patterns("derived"))
    heard = changes(tmp_path / "it", "report", str(tmp_path / "it"))
    assert heard
    assert not [line for line in heard if not line.split(maxsplit=1)[1].startswith("derived")]


def test_two_folders_are_read_in_place(ran, tmp_path):
    """Nothing of them is changed, and nothing is left in the folder for temporary files."""
    shutil.copytree(ran, tmp_path / "other")
    before = files_of(ran)
    scratch = tmp_path / "scratch"
    scratch.mkdir()
    environment = {**os.environ, "TMPDIR": str(scratch)}
    command = [sys.executable, "-m", "harness", "report", str(ran), str(tmp_path / "other")]
    assert subprocess.run(command, capture_output=True, check=False, env=environment).returncode == 0
    assert files_of(ran) == before
    assert not list(scratch.iterdir())
