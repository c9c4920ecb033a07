"""Files by the names that a `robot.toml`, a command or a xacro file gives them: paths, and files of packages."""

import difflib
import glob
import os
import re
from collections.abc import Iterator, Mapping
from importlib.metadata import Distribution, PackageNotFoundError, distribution, packages_distributions
from importlib.util import find_spec
from itertools import islice
from pathlib import Path, PurePosixPath

from harness.errors import UsageError
from harness.files.bounded import read_text
from harness.registry.spec import did_you_mean

INSTALLED = re.compile(r"([A-Za-z0-9][A-Za-z0-9._-]+):([^/\\:][^:]*)")
"""``pybullet_data:kuka_iiwa/model.urdf``; one letter and a colon is a drive, and ``file://`` begins with slashes."""
MOST_FILES = 20_000
"""Files of a package that are looked at for a near miss."""
SHOWN = 5
MOST_BYTES = 2**20
"""The most bytes of a package.xml."""


def is_installed(name: str) -> bool:
    """Whether a text is the name of a package, a colon, and the path of a file in it."""
    return INSTALLED.fullmatch(name) is not None


def locate(name: str, folder: Path, place: str) -> Path:
    """The file or folder that a name means.

    Args:
        name: A path, absolute or from `folder` on; or ``PACKAGE:PATH``, see `find_installed`.
        folder: Of the robot.toml.
        place: What an error begins with.

    Raises:
        UsageError: There is no such package, or no such file in it.
    """
    if is_installed(name) and not os.path.exists(folder / name):  # no error, whatever the name
        return find_installed(name, place)
    return folder / expanded(name)


def expanded(name: str) -> Path:
    """A path that may begin at the user's home."""
    return Path(name).expanduser() if name == "~" or name.startswith("~/") else Path(name)


def find_installed(name: str, place: str = "") -> Path:
    """A file or folder of an installed package, which is not imported.

    Args:
        name: ``PACKAGE:PATH``. PACKAGE is what a program imports, PATH begins in its folder; or else it is what pip
            installs, and PATH begins where pip installs.
        place: What an error begins with.

    Raises:
        UsageError: There is no such package, or no such file in it.
    """
    begin = f"{place}: " * bool(place)
    package, _, path = name.partition(":")
    folders, brought = _folders_of(package), _distribution_of(package)
    if not folders and brought is None:
        known = packages_distributions()
        meant = did_you_mean(package, {*known, *(name for names in known.values() for name in names)})
        told = f"No package '{package}' is installed.{meant}"
        raise UsageError(f"{begin}{told} Correct the name, install it, or give the path of a file.")
    places = folders or [Path(str(brought.locate_file("")))] if brought is not None else folders
    for folder in places:
        if os.path.exists(folder / path):
            return folder / path
    files = islice(_files_in(folders) if folders or brought is None else map(str, brought.files or ()), MOST_FILES)
    ending = PurePosixPath(path).suffix or ".urdf"
    there = sorted(file for file in files if file.endswith(ending))
    near = difflib.get_close_matches(path, there, n=SHOWN) or there[:SHOWN]
    told = f"Of {ending} there is: {', '.join(near)}" if near else f"No {ending} file lies there"
    raise UsageError(f"{begin}'{package}' in {places[0]} has no '{path}'. {told}. Correct the path.")


def _folders_of(package: str) -> list[Path]:
    """The folders of what a program imports by a name; none where there is none."""
    try:
        spec = None if "." in package else find_spec(package)  # with a dot it would import what stands before it
    except (ImportError, ValueError):
        return []
    return [Path(folder) for folder in (spec.submodule_search_locations or [])] if spec else []


def _distribution_of(package: str) -> Distribution | None:
    try:
        return distribution(package)
    except (PackageNotFoundError, ValueError):
        return None


def _files_in(folders: list[Path]) -> Iterator[str]:
    for folder in folders:
        for path, _, names in os.walk(folder):
            begin = Path(path).relative_to(folder)
            yield from ((begin / name).as_posix() for name in names)


def package_folders(name: str, folder: Path, packages: Mapping[str, Path]) -> Iterator[Path]:
    """Where the folder of a ROS package may be, likeliest first.

    Looked at are those that `packages` names, those around `folder`, those beside them, those that ROS_PACKAGE_PATH
    lists and those in them, and ``share`` in those that AMENT_PREFIX_PATH lists. A folder around `folder` is also known
    by its ``package.xml``.

    Args:
        name: Of the package.
        folder: Where it is asked for.
        packages: Folders of packages by their names; that of the name '' holds all others.
    """
    if name in packages:
        yield packages[name]
    around = (folder.absolute(), *folder.absolute().parents)
    listed, installed = (
        [Path(place).absolute() for place in os.environ.get(variable, "").split(os.pathsep) if place]
        for variable in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
    )
    given = [packages[""]] if "" in packages else []

    def is_it(place: Path) -> bool:
        return name in {place.name, _named_by(place / "package.xml")}

    yield from filter(is_it, around)
    yield from (place / name for place in (*given, *around))
    yield from filter(is_it, listed)
    yield from (place / name for place in (*listed, *(it / "share" for it in installed)))
    yield from (found for place in listed for found in sorted(place.glob(f"*/{glob.escape(name)}")))


def _named_by(manifest: Path) -> str:
    """The name that a package.xml gives its package; empty without such a file."""
    try:
        found = re.search(r"<name>\s*([^<\s]+)\s*</name>", read_text(manifest, MOST_BYTES))
    except (OSError, UnicodeDecodeError):
        return ""
    return found[1] if found else ""
