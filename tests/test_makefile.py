"""What make installs, and what it does for the records of an experiment; a stand-in only says how it was called."""

import hashlib
import os
import shutil
import subprocess
import sys

import pytest

from tests.project import ROOT

MAKEFILE = ROOT / "Makefile"
HARNESS = """#!/bin/sh
echo "$@" >> calls.txt
case $1 in
    run) exit $RUN_STATUS ;;
    report) mkdir -p "$4" && touch "$4/summary.md" && echo "id,status,reason\\n1,$LEFT,not run yet" > "$4/cells.csv" ;;
esac
"""

PYTHON = """#!/bin/sh
echo "$@" >> calls.txt
case $2 in venv) mkdir -p "$3/bin" && cp "$0" "$3/bin/python" ;; esac
"""
SHOWN = "docs/pictures/shown.py"
SOURCES = ("pyproject.toml", "constraints.txt", "requirements/run.txt", "requirements/dev.txt")

pytestmark = pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")


@pytest.fixture
def checkout(tmp_path):
    """A copy of the Makefile with an experiment of one line, and all installed."""
    shutil.copy(MAKEFILE, tmp_path)
    for name in (*SOURCES, ".venv/bin/harness", ".venv/.installed", ".venv/.installed-dev", "README.md", SHOWN):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).touch()
    shutil.copy(MAKEFILE.parent / SHOWN, tmp_path / SHOWN)
    (tmp_path / ".venv/bin/harness").write_text(HARNESS)
    (tmp_path / ".venv/bin/harness").chmod(0o755)
    (tmp_path / ".venv/bin/python").symlink_to(sys.executable)
    (tmp_path / "experiments").mkdir()
    (tmp_path / "experiments/my_own.toml").write_text("seeds = 3\n")
    return tmp_path


@pytest.fixture
def empty_checkout(tmp_path):
    """A copy of the Makefile with nothing installed, and a Python that installs nothing."""
    shutil.copy(MAKEFILE, tmp_path)
    (tmp_path / "requirements").mkdir()
    for name in SOURCES:
        (tmp_path / name).touch()
    (tmp_path / "python").write_text(PYTHON)
    (tmp_path / "python").chmod(0o755)
    return tmp_path


def _run_make(checkout, *arguments, **told):
    """Status and words of make with these arguments."""
    inherited = ("MAKE", "MFLAGS", "EXPERIMENT", "VENV", "PYTHON", "TORCH_INDEX")
    outer = {name: value for name, value in os.environ.items() if not name.startswith(inherited)}
    command = ["make", *arguments]
    ended = subprocess.run(command, cwd=checkout, env={**outer, **told}, capture_output=True, text=True, check=False)
    return ended.returncode, ended.stdout + ended.stderr


def _make(checkout, experiment="my_own", run_status=0, left="done"):
    """Status and words of `make reference`, where the run ends so and leaves its cell so."""
    return _run_make(checkout, "reference", f"EXPERIMENT={experiment}", RUN_STATUS=str(run_status), LEFT=left)


def _calls(checkout):
    return (checkout / "calls.txt").read_text().splitlines()


def _installations(checkout):
    """What pip was told to install since this was last asked."""
    calls = _calls(checkout)
    (checkout / "calls.txt").write_text("")
    return [call.partition(" install --quiet ")[2] for call in calls if " install " in call]


def test_run_installs_its_lock_and_no_torch(empty_checkout):
    """The lock by its hashes, then the project with nothing else."""
    assert _run_make(empty_checkout, "install", "PYTHON=./python")[0] == 0
    assert _installations(empty_checkout) == [
        "--no-deps --require-hashes --requirement requirements/run.txt",
        "--no-deps --no-build-isolation --editable .",
    ]


def test_torch_alone_comes_from_its_index(empty_checkout):
    """Everything else comes from where pip looks anyway."""
    assert _run_make(empty_checkout, "dev", "PYTHON=./python", "TORCH_INDEX=https://torch.example/cpu")[0] == 0
    told = [call for call in _installations(empty_checkout) if "torch.example" in call]
    assert told == ["--constraint constraints.txt --index-url https://torch.example/cpu torch"]


def test_dev_adds_the_larger_lock_and_torch(empty_checkout):
    """To what users install; torch last, which finds all that it needs."""
    assert _run_make(empty_checkout, "install", "PYTHON=./python")[0] == 0
    _installations(empty_checkout)
    assert _run_make(empty_checkout, "dev", "PYTHON=./python")[0] == 0
    assert _installations(empty_checkout) == [
        "--no-deps --require-hashes --requirement requirements/dev.txt",
        "--constraint constraints.txt torch",
    ]


@pytest.mark.parametrize("name", SOURCES)
def test_changed_lock_is_installed_again(empty_checkout, name):
    """As is a changed pyproject.toml or constraints.txt; and where nothing changed, nothing is done."""
    assert _run_make(empty_checkout, "dev", "PYTHON=./python")[0] == 0
    _installations(empty_checkout)
    assert _run_make(empty_checkout, "dev", "PYTHON=./python")[0] == 0
    assert _installations(empty_checkout) == []
    later = (empty_checkout / ".venv/.installed-dev").stat().st_mtime + 1
    os.utime(empty_checkout / name, (later, later))
    assert _run_make(empty_checkout, "dev", "PYTHON=./python")[0] == 0
    assert "--no-deps --require-hashes --requirement requirements/dev.txt" in _installations(empty_checkout)


def test_lock_takes_up_what_it_is_told(empty_checkout):
    """One package, all, or nothing but what pyproject.toml and constraints.txt ask for."""
    words = {
        upgrade: _run_make(empty_checkout, "--dry-run", "lock", f"UPGRADE={upgrade}")[1]
        for upgrade in ("", "pytest", "all")
    }
    assert "--upgrade" not in words[""]
    assert "--upgrade-package=pytest" in words["pytest"]
    assert "--upgrade " in words["all"]


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


@pytest.fixture
def checkout_with_packages(checkout):
    """One more experiment, in a folder with packages of its own, which are installed."""
    folder, built = checkout / "experiments/other-world", checkout / "build/experiments/other-world"
    folder.mkdir()
    (built / "bin").mkdir(parents=True)
    (folder / "reach_far.toml").write_text("seeds = 3\n")
    (folder / "requirements.txt").write_text("other-world==1\n")
    (built / "installed").touch()
    (built / "bin/python").write_text(HARNESS.replace("$1", "$3").replace("$4", "$6"))
    (built / "bin/python").chmod(0o755)
    return checkout


def test_experiment_with_packages_runs_with_them(checkout_with_packages):
    """Its cells and its records stand in a folder of that name; no harness but theirs is asked."""
    assert _make(checkout_with_packages, "other-world/reach_far")[0] == 0
    content = (checkout_with_packages / "experiments/other-world/reach_far.toml").read_bytes()
    folder = f"results/runs/other-world/reach_far-{hashlib.sha256(content).hexdigest()[:8]}"
    assert _calls(checkout_with_packages) == [
        f"-m harness run experiments/other-world/reach_far.toml --out {folder}",
        f"-m harness report {folder} --summary results/reference/other-world/reach-far",
    ]


def test_experiment_without_packages_runs_without_any(checkout_with_packages):
    """What another folder asks for is neither installed nor used."""
    assert _make(checkout_with_packages)[0] == 0
    assert not any(call.startswith("-m") for call in _calls(checkout_with_packages))


def test_changed_packages_are_installed_again(checkout_with_packages):
    """Into a new environment of that folder, behind which those of the lock stand."""
    later = (checkout_with_packages / "build/experiments/other-world/installed").stat().st_mtime + 1
    os.utime(checkout_with_packages / "experiments/other-world/requirements.txt", (later, later))
    _, words = _run_make(checkout_with_packages, "--dry-run", "reference", "EXPERIMENT=other-world/reach_far")
    assert "python -m venv --without-pip --clear build/experiments/other-world" in words
    installation = "--python build/experiments/other-world install --quiet --requirement"
    assert f"{installation} experiments/other-world/requirements.txt" in words


def test_unknown_experiment_is_refused(checkout):
    """Before anything is run."""
    status, words = _make(checkout, experiment="nothing")
    assert (status, (checkout / "calls.txt").exists()) == (2, False)
    assert "make reference EXPERIMENT=arp_2021" in words
