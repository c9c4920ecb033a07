"""Where a robot's description comes from: its `robot.toml`, its file, and the text of its URDF."""

import errno
import os
import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path

from harness.errors import UsageError
from harness.files.bounded import read_bytes, read_text
from harness.registry.choice import Registry
from harness.registry.registry import load_registry
from harness.robot.description import Description, read_description
from harness.robot.packages import expanded, find_installed, is_installed, locate
from harness.robot.settings import ARGUMENTS, FILE, RobotSettings, read_settings

MOST_BYTES = 4 * 2**20
"""The most bytes of a URDF: 200 for each of the elements that it may have. A humanoid's has a fifth of a megabyte."""
FOREIGN = (b"<xacro:", b"\0")
"""What no URDF has: macros, and bytes of an archive."""
COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)

PACKAGES = {"site-packages", "dist-packages"}
"""Folders that pip installs packages into."""


@dataclass(frozen=True)
class Source:
    """A robot as it was given.

    Attributes:
        settings: The robot.toml, empty where there is none.
        path: The file that describes the arm; the names of meshes start in its folder.
        described: What its reader understood; of a URDF its text alone.
    """

    settings: RobotSettings
    path: Path
    described: Description


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """Put the file before what is wrong with it."""
    try:
        yield
    except UsageError as error:
        raise UsageError(f"{path}: {error}") from error


def read_source(path: Path, registry: Registry | None = None) -> Source:
    """The description at `path`.

    Args:
        path: Of a folder with a robot.toml, of that file, or of a URDF beside which one may lie; also as a file of an
            installed package, see `harness.robot.packages.find_installed`. In place of a URDF may stand what a
            registered reader makes one of.
        registry: Has these readers; loaded if None.

    Raises:
        UsageError: A file cannot be read; the message names it.
    """
    settings, file = _find_files(path)
    arguments = settings.arguments()
    if not _may_be_urdf(file):
        described = read_description(file, arguments, settings.folders(), registry or load_registry())
        if described is not None:
            return Source(settings, file, described)
    if arguments:
        raise UsageError(f"{settings.path}: {ARGUMENTS} are given, and {file.name} is a URDF, which takes none.")
    try:
        return Source(settings, file, Description(read_text(file, MOST_BYTES)))
    except OSError as error:
        raise UsageError(f"{file}: cannot be read ({error.strerror}). A robot is a URDF and its {FILE}.") from error
    except UnicodeDecodeError as error:
        raise UsageError(f"{file}: is not UTF-8 text ({error.reason}). Save it as UTF-8.") from error


def _may_be_urdf(path: Path) -> bool:
    """Whether a file is a URDF, or cannot be read at all."""
    try:
        data = COMMENT.sub(b"", read_bytes(path, MOST_BYTES))
    except OSError as error:
        return error.errno != errno.EFBIG or path.suffix.lower() == ".urdf"
    return path.suffix.lower() != ".xacro" and b"<robot" in data and not any(mark in data for mark in FOREIGN)


def _find_files(path: Path) -> tuple[RobotSettings, Path]:
    """The robot.toml, empty where there is none, and the URDF's path."""
    found = find_installed(str(path)) if is_installed(str(path)) and not os.path.exists(path) else path
    if found.name == FILE and found.is_file():
        found = found.parent
    settings, file = _find_in_folder(found) if found.is_dir() else _find_beside(found)
    if PACKAGES & set(settings.path.absolute().parts):
        settings = replace(settings, installed=str(path if found is not path and file == found else file.absolute()))
    return settings, file


def _find_beside(path: Path) -> tuple[RobotSettings, Path]:
    """The robot.toml beside a file, and the file; of one that names another file nothing is taken."""
    beside = path.parent / FILE
    if beside.is_file():
        settings = read_settings(beside)
        named = settings.text("urdf")
        if named is None or os.path.realpath(beside.parent / expanded(named)) == os.path.realpath(path):
            return settings, path
    return RobotSettings(beside), path


def _find_in_folder(folder: Path) -> tuple[RobotSettings, Path]:
    if not (folder / FILE).exists():
        raise UsageError(f"{folder}: no {FILE} in it. Give the path of a URDF, or write a {FILE} that names one.")
    settings = read_settings(folder / FILE)
    name = settings.text("urdf")
    if name is None:
        raise UsageError(
            f"{settings.path}: missing urdf. Name the URDF's file, or give its path instead of the folder."
        )
    return settings, locate(name, folder, str(settings.path))
