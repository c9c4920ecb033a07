"""Who packages the project has the source archive alone: it holds the repository, and a wheel is built from it."""

import shutil
import subprocess
import sys
import tarfile
import zipfile

import pytest

from tests.installed.conftest import ROOT

MADE = ("PKG-INFO", "setup.cfg", "fd100_harness.egg-info/")
"""What the archive has besides the repository's files."""

pytestmark = pytest.mark.slow


def _build(kind, source, out):
    command = [sys.executable, "-m", "build", "--no-isolation", "--quiet", f"--{kind}", "--outdir", out, source]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    (built,) = out.iterdir()
    return built


@pytest.fixture(scope="module")
def repository(tmp_path_factory):
    """The files that git knows, or would add, in a folder of their own: what is left from other builds stays behind."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    listed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("this is no checkout: git lists no files")
    folder = tmp_path_factory.mktemp("repository")
    for name in listed.stdout.splitlines():
        if (ROOT / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, folder / name)
    return folder


@pytest.fixture(scope="module")
def files(repository):
    """The names of the repository's files, before anything is built there."""
    return {path.relative_to(repository).as_posix() for path in repository.rglob("*") if path.is_file()}


@pytest.fixture(scope="module")
def unpacked(repository, files, tmp_path_factory):
    """The archive's folder."""
    place = tmp_path_factory.mktemp("unpacked")
    with tarfile.open(_build("sdist", repository, tmp_path_factory.mktemp("sdist"))) as archive:
        archive.extractall(place, filter="data")
    (folder,) = place.iterdir()
    return folder


def test_the_archive_holds_the_repository(unpacked, files):
    """Tests with what they share, pages, Makefile and locks: the tests can be run from it."""
    packed = {path.relative_to(unpacked).as_posix() for path in unpacked.rglob("*") if path.is_file()}
    assert {"Makefile", "tests/conftest.py", "docs/index.md", "requirements/dev.txt"} <= packed
    assert sorted(files - packed) == []


def test_the_archive_holds_nothing_else(unpacked, files):
    """Nothing of the machine where it was built."""
    packed = {path.relative_to(unpacked).as_posix() for path in unpacked.rglob("*") if path.is_file()}
    assert sorted(name for name in packed - files if not name.startswith(MADE)) == []


def test_a_wheel_is_built_from_the_archive(unpacked, repository, tmp_path_factory):
    """The same as from the repository, byte for byte in every file."""

    def contents(source):
        with zipfile.ZipFile(_build("wheel", source, tmp_path_factory.mktemp("wheel"))) as archive:
            return {entry.filename: entry.CRC for entry in archive.infolist()}

    assert contents(unpacked) == contents(repository)
