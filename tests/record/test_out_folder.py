"""A folder that a user names: made, and kept to one program at a time."""

import subprocess
import sys
import tomllib

import pytest
from packaging.requirements import Requirement

from harness.errors import StorageError, UsageError
from harness.record.out_folder import folder_lock, make_folder, refuse_links, storage_errors
from tests.project import ROOT

HOLD = """
import sys
from pathlib import Path
from harness.record.out_folder import folder_lock

with folder_lock(Path(sys.argv[1]), "busy"):
    print("held", flush=True)
    sys.stdin.read()
"""

GUARDED = "    try:\n        import fcntl\n    except ImportError:\n"


@pytest.fixture
def holder(tmp_path):
    """Another process that holds the folder."""
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE}
    with subprocess.Popen([sys.executable, "-c", HOLD, str(tmp_path / ".lock")], text=True, **pipes) as holder:
        assert holder.stdout.readline() == "held\n"
        yield holder


def test_second_process_is_refused_until_the_first_one_ends(holder, tmp_path):
    """By one line that says what to do; a process that is killed lets go."""
    path = tmp_path / ".lock"
    with pytest.raises(UsageError, match=r"^In use: wait for it, or name another --out$"), folder_lock(path, "In use"):
        pass
    holder.kill()
    holder.wait()
    with folder_lock(path, "In use"):
        assert path.exists()


def test_one_process_does_not_hold_it_twice(tmp_path):
    """Two runs in one program do not meet in one folder either."""
    with (
        folder_lock(tmp_path / ".lock", "In use"),
        pytest.raises(UsageError),
        folder_lock(tmp_path / ".lock", "In use"),
    ):
        pass


def test_nothing_but_portable_modules_is_imported():
    """`fcntl` does not exist on Windows: whoever imports it has an answer for where it is missing."""
    found = [path for folder in ("harness", "plugins") for path in (ROOT / folder).rglob("*.py")]
    assert found
    texts = {path: path.read_text(encoding="utf-8") for path in found}
    assert not [path for path, text in texts.items() if "import fcntl" in text.replace(GUARDED, "")]


def test_folder_is_made_with_what_is_in_it(tmp_path):
    """A second time nothing happens."""
    for _ in range(2):
        make_folder(tmp_path / "deep" / "down", "cells")
    assert (tmp_path / "deep" / "down" / "cells").is_dir()


def test_second_process_waits_if_it_is_told_to(holder, tmp_path):
    """It says so once, and has the folder when the first one lets go."""
    told = []

    def let_go():
        told.append("waiting")
        holder.stdin.close()

    with folder_lock(tmp_path / ".lock", "In use", let_go):
        assert told == ["waiting"]


@pytest.mark.parametrize("inner", ["plan.json", ".lock", "cells", "cells/x", "cells/x/trace.parquet"])
def test_link_in_a_folder_is_refused(tmp_path, inner):
    """What is written into it would land elsewhere; the line names it."""
    path = tmp_path / "out" / inner
    path.parent.mkdir(parents=True, exist_ok=True)
    path.symlink_to(tmp_path / "elsewhere")
    with pytest.raises(UsageError, match=f"^'{path}' is a link; nothing is written into a folder with links"):
        refuse_links(tmp_path / "out")


@pytest.mark.parametrize("inner", [".0.partial/log.txt", "0/trace.parquet"])
def test_a_second_name_of_a_file_that_grows_is_refused(tmp_path, inner):
    """What is appended would land in the other one; files that are replaced may have as many as they like."""
    (tmp_path / "it" / "0").mkdir(parents=True)
    (tmp_path / "it" / "0" / "checkpoint.safetensors").write_text("")
    (tmp_path / "of a person").write_text("kept")
    (tmp_path / "it" / "report.html").hardlink_to(tmp_path / "of a person")
    refuse_links(tmp_path / "it")
    (tmp_path / "it" / inner).parent.mkdir(exist_ok=True)
    (tmp_path / "it" / inner).hardlink_to(tmp_path / "of a person")
    with pytest.raises(UsageError, match=f"{inner}' is a link"):
        refuse_links(tmp_path / "it")


@pytest.mark.skipif(sys.platform != "linux", reason="other systems take text alone")
def test_a_folder_whose_name_is_no_text_is_refused(tmp_path):
    """Libraries that write into it would end with a traceback, after the training."""
    with pytest.raises(UsageError, match=r"--out .* is not written in UTF-8"):
        make_folder(tmp_path / "bad\udcff")
    assert not list(tmp_path.iterdir())


def test_folder_may_be_a_link_itself(tmp_path):
    """The user says where his results go."""
    (tmp_path / "disk").mkdir()
    (tmp_path / "out").symlink_to(tmp_path / "disk")
    refuse_links(tmp_path / "out")
    make_folder(tmp_path / "out", "cells")
    assert (tmp_path / "disk" / "cells").is_dir()


def test_versions_that_emptied_what_a_link_leads_to_are_not_allowed():
    """Before 3.20.3 whoever laid a link in time had its target emptied."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    (asked,) = (Requirement(text) for text in project["dependencies"] if text.startswith("filelock"))
    assert [version for version in ("3.16", "3.20.2", "3.20.3") if asked.specifier.contains(version)] == ["3.20.3"]


def test_a_folder_that_is_gone_is_called_gone(tmp_path):
    """Nothing of it is kept, and no disk is full; a file that is missing in a folder that is there is told as such."""
    with pytest.raises(StorageError, match="it' is gone"), storage_errors(tmp_path / "it"):
        (tmp_path / "it" / "file").write_text("")
    with pytest.raises(StorageError, match="cannot be written: No such file"), storage_errors(tmp_path):
        (tmp_path / "it" / "file").write_text("")
