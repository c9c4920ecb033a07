"""The files of a summary, put in place of the old ones."""

import os
import subprocess
import sys

import pytest

from harness.errors import UsageError
from harness_plugins.committed.records import PARTIAL, put_files
from harness_plugins.committed.svg import CREATOR

OLD = {"a.txt": b"old a", "b.txt": b"old b", "figures/c.svg": b"old c"}
NEW = {"a.txt": b"new a", "b.txt": b"new b", "figures/c.svg": b"new c"}


def read(folder):
    """Everything in it."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def folder(tmp_path):
    """One that holds an older summary, and a file of somebody else's."""
    put_files(tmp_path / "mine", OLD, "figures")
    (tmp_path / "mine" / "published.toml").write_bytes(b"theirs")
    return tmp_path / "mine"


def test_old_files_are_replaced_and_others_stay(folder):
    """Ours are the new ones; nothing else is touched or left over."""
    put_files(folder, NEW, "figures")
    assert read(folder) == {**NEW, "published.toml": b"theirs"}


def test_error_while_writing_leaves_the_old_files(folder, monkeypatch):
    """A full disk costs nothing: one line, the old files, no remains."""
    written = []

    def refuse(path, content):
        if written:
            raise OSError(28, "No space left on device")
        written.append(path)

    monkeypatch.setattr("pathlib.Path.write_bytes", refuse)
    with pytest.raises(UsageError, match="mine' cannot be written: No space left on device"):
        put_files(folder, NEW, "figures")
    assert read(folder) == {**OLD, "published.toml": b"theirs"}


def test_killed_writer_leaves_whole_old_files(folder):
    """Killed before the last file is written, the folder is as it was; the next writer clears what is left."""
    code = (
        "import os, pathlib, signal, sys\n"
        "from harness_plugins.committed.records import put_files\n"
        "write = pathlib.Path.write_bytes\n"
        "def write_half(path, content):\n"
        "    write(path, content[:2])\n"
        "    if path.name == 'c.svg': os.kill(os.getpid(), signal.SIGKILL)\n"
        "pathlib.Path.write_bytes = write_half\n"
        f"put_files(pathlib.Path(sys.argv[1]), {NEW!r}, 'figures')\n"
    )
    ended = subprocess.run([sys.executable, "-c", code, str(folder)], check=False)
    assert ended.returncode == -9
    left = {name: content for name, content in read(folder).items() if not name.startswith(PARTIAL)}
    assert left == {**OLD, "published.toml": b"theirs"}
    assert (folder / PARTIAL).is_dir()
    put_files(folder, NEW, "figures")
    assert read(folder) == {**NEW, "published.toml": b"theirs"}


def test_interrupted_renaming_leaves_whole_files(folder, monkeypatch):
    """Each file is the old one or the new one."""
    replace, renamed = os.replace, []

    def replace_once(source, target):
        if renamed:
            raise KeyboardInterrupt
        renamed.append(target)
        replace(source, target)

    monkeypatch.setattr("os.replace", replace_once)
    with pytest.raises(KeyboardInterrupt):
        put_files(folder, NEW, "figures")
    left = read(folder)
    assert set(left) == {*OLD, "published.toml"}
    assert all(left[name] in (OLD[name], NEW[name]) for name in OLD)


def test_our_older_figures_go(folder):
    """One that is not drawn any more would be taken for a result."""
    for name in ("overview", "a.runs", "a-b.1.split", "a.learning"):
        (folder / "figures" / f"{name}.svg").write_text(f"<svg>{CREATOR}</svg>")
    put_files(folder, NEW, "figures")
    assert {path.name for path in (folder / "figures").iterdir()} == {"c.svg"}


@pytest.mark.parametrize("name", ["theirs.svg", "a.runs-kept.svg", "runs.svg", "overview2.svg", "a.runs.kept.svg"])
def test_figures_of_another_name_stay(folder, name):
    """A copy of ours that somebody renamed is theirs."""
    (folder / "figures" / name).write_text(f"<svg>{CREATOR}</svg>")
    put_files(folder, NEW, "figures")
    assert {path.name for path in (folder / "figures").iterdir()} == {"c.svg", name}


def test_figures_of_another_creator_stay(folder):
    """Whatever their name."""
    (folder / "figures" / "overview.svg").write_text("<svg/>")
    put_files(folder, NEW, "figures")
    assert {path.name for path in (folder / "figures").iterdir()} == {"c.svg", "overview.svg"}


def test_folder_that_is_a_file_is_refused(tmp_path):
    """In one line."""
    (tmp_path / "mine").touch()
    with pytest.raises(UsageError, match="mine' cannot be written"):
        put_files(tmp_path / "mine", NEW, "figures")
