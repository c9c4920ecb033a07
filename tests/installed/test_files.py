"""What the wheel and the source archive hold: every file that the code needs, and every file of the repository."""

import subprocess
import zipfile
from pathlib import Path

import pytest
import setuptools  # noqa: F401 # it brings distutils, which Python no longer has from 3.12 on

from distutils.core import run_setup  # isort: skip
from distutils.filelist import FileList  # isort: skip

from tests.installed.conftest import ROOT

PACKAGES = {"harness": "harness", "plugins": "harness_plugins", "robots": "harness_robots"}
NOT_PACKAGED = ("__pycache__",)


def _files_in_tree():
    """Of the packages, as paths in the wheel."""
    found = set()
    for folder, package in PACKAGES.items():
        for path in (ROOT / folder).rglob("*"):
            if path.is_file() and not set(path.parts) & set(NOT_PACKAGED):
                found.add(f"{package}/{path.relative_to(ROOT / folder).as_posix()}")
    return found


@pytest.fixture
def in_root(monkeypatch):
    """Where setuptools looks for what it packs."""
    monkeypatch.chdir(ROOT)


def test_wheel_will_hold_every_file_of_the_packages(in_root):
    """Templates, style sheets and robots too: a checkout has them anyway, so nothing else finds what is forgotten."""
    distribution = run_setup("setup.py", script_args=["--quiet"], stop_after="init")
    distribution.parse_config_files()
    packing = distribution.get_command_obj("build_py")
    packing.ensure_finalized()
    packed = {
        f"{package.replace('.', '/')}/{Path(name).as_posix()}"
        for package, _, _, names in packing.data_files
        for name in names
    }
    packed |= {f"{package.replace('.', '/')}/{Path(path).name}" for package, _, path in packing.find_all_modules()}
    assert sorted(_files_in_tree() - packed) == []


def _files_in_git():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("this is no checkout: git lists no files")
    return {name for name in listed.stdout.splitlines() if (ROOT / name).is_file()}


def test_source_archive_will_hold_every_file_of_the_repository(in_root):
    """By MANIFEST.in."""
    files = FileList()
    files.findall()
    for line in (ROOT / "MANIFEST.in").read_text().splitlines():
        if line and not line.startswith("#"):
            files.process_template_line(line)
    assert sorted(_files_in_git() - {Path(name).as_posix() for name in files.files}) == []


@pytest.mark.slow
def test_built_wheel_holds_every_file_of_the_packages(wheel):
    """It was built from the source archive, so that holds them too."""
    with zipfile.ZipFile(wheel) as archive:
        packed = set(archive.namelist())
    assert sorted(_files_in_tree() - packed) == []
