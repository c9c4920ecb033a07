"""What make does for the records of an experiment, with a harness that only says how it was called."""

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

MAKEFILE = Path(__file__).parents[1] / "Makefile"
HARNESS = """#!/bin/sh
echo "$@" >> calls.txt
case $1 in
    run) exit $RUN_STATUS ;;
    report) mkdir -p "$4" && echo "id,status,reason\\n1,$LEFT,not run yet" > "$4/cells.csv" ;;
esac
"""

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


@pytest.fixture
def checkout(tmp_path):
    """A copy of the Makefile with an experiment of one line, and all installed."""
    shutil.copy(MAKEFILE, tmp_path)
    for name in ("pyproject.toml", "constraints.txt", ".venv/bin/harness", ".venv/.installed", ".venv/.installed-dev"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    (tmp_path / ".venv/bin/harness").write_text(HARNESS)
    (tmp_path / ".venv/bin/harness").chmod(0o755)
    (tmp_path / ".venv/bin/python").symlink_to(sys.executable)
    (tmp_path / "experiments").mkdir()
    (tmp_path / "experiments/my_own.toml").write_text("seeds = 3\n")
    return tmp_path


def _make(checkout, experiment="my_own", run_status=0, left="done"):
    """Status and words of `make reference`, where the run ends so and leaves its cell so."""
    told = {"RUN_STATUS": str(run_status), "LEFT": left}
    outer = {name: value for name, value in os.environ.items() if not name.startswith(("MAKE", "MFLAGS", "EXPERIMENT"))}
    command = ["make", "reference", f"EXPERIMENT={experiment}"]
    ended = subprocess.run(command, cwd=checkout, env={**outer, **told}, capture_output=True, text=True, check=False)
    return ended.returncode, ended.stdout + ended.stderr


def _calls(checkout):
    return (checkout / "calls.txt").read_text().splitlines()


def test_cells_are_kept_by_the_content_of_the_file(checkout):
    """The folder's name has its hash; run and report name the same folder."""
    assert _make(checkout)[0] == 0
    content = (checkout / "experiments/my_own.toml").read_bytes()
    folder = f"results/runs/my_own-{hashlib.sha256(content).hexdigest()[:8]}"
    assert _calls(checkout) == [
        f"run experiments/my_own.toml --out {folder}",
        f"report {folder} --summary results/reference/my-own",
    ]


def test_another_content_is_another_folder(checkout):
    """Cells of an older file do not get into the records of a newer one."""
    _make(checkout)
    (checkout / "experiments/my_own.toml").write_text("seeds = 4\n")
    _make(checkout)
    old, _, new, _ = _calls(checkout)
    assert old != new


def test_failed_cells_are_part_of_the_record(checkout):
    """They end a run with status 1."""
    assert _make(checkout, run_status=1, left="failed")[0] == 0


def test_pending_cells_are_an_error(checkout):
    """A run that ends with a traceback has status 1 too; what it has not done is told."""
    status, words = _make(checkout, run_status=1, left="pending")
    assert status == 2
    assert "1,pending,not run yet" in words


def test_run_that_cannot_begin_is_an_error(checkout):
    """And there is no report."""
    assert _make(checkout, run_status=2)[0] == 2
    assert len(_calls(checkout)) == 1


def test_unknown_experiment_is_refused(checkout):
    """Before anything is run."""
    status, words = _make(checkout, experiment="nothing")
    assert (status, (checkout / "calls.txt").exists()) == (2, False)
    assert "make reference EXPERIMENT=arp_2021" in words
