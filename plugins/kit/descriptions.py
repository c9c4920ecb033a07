"""What a format of robots' descriptions must satisfy. Each check takes the format and an empty folder."""

from collections.abc import Mapping
from pathlib import Path

from harness.authoring.checking import (
    HEAD_BYTES,
    Urdf,
    allow_programs,
    find_chain_end,
    parse_urdf,
    read_chain,
)
from harness.errors import HarnessError, UsageError
from harness.robot import Description, DescriptionFormat

from .contract import Check, check, raise_first_in_folders, require, settings_are_frozen, settings_survive_json

OTHERS = {
    "empty": b"",
    "URDF": b'<?xml version="1.0"?>\n<robot name="arm">\n  <link name="base"/>\n</robot>\n',
    "table": b"step,reward\n0,1\n",
    "bytes": bytes(range(256)),
}
"""Files of no format but URDF."""


def check_description_format(form: DescriptionFormat, folder: Path | None = None) -> None:
    """Run all `DESCRIPTION_CHECKS`.

    Args:
        form: To be checked.
        folder: To work in; one for temporary files if None.

    Raises:
        ContractViolation: At the first check that fails.
    """
    raise_first_in_folders(DESCRIPTION_CHECKS, form, folder)


@check("description-recognises")
def its_own_files_are_recognised(form: DescriptionFormat, folder: Path) -> None:
    """`recognises` says yes to the format's own example, and no to a URDF, a table, an empty file and odd bytes."""
    path = _example(form, folder)
    require(form.recognises(path, path.read_bytes()[:HEAD_BYTES]) is True, f"recognises does not take '{path.name}'")
    for what, content in OTHERS.items():
        other = folder / f"other{'.urdf' if what == 'URDF' else ''}"
        other.write_bytes(content)
        require(form.recognises(other, content) is False, f"recognises takes what is {what}")


@check("description-urdf")
def a_urdf_comes_of_it(form: DescriptionFormat, folder: Path) -> None:
    """`read` gives a URDF with a chain that moves."""
    urdf = _read(form, _example(form, folder))[1]
    read_chain(urdf, find_chain_end(urdf))  # raises, and says why


@check("description-names")
def names_are_those_of_the_urdf(form: DescriptionFormat, folder: Path) -> None:
    """The tip is a link of the URDF, and the resting pose names joints of it that move."""
    described, urdf = _read(form, _example(form, folder))
    require(described.tip is None or described.tip in urdf.links, f"the tip '{described.tip}' is no link")
    moving = {joint.get("name") for joint in urdf.joints if joint.get("type") != "fixed"}
    unknown = sorted(described.home.keys() - moving)
    require(not unknown, f"home names {unknown}, which are no joints that move")
    require(bool(described.home) == bool(described.home_origin), "home and home_origin are not given together")


@check("description-again")
def reading_twice_is_the_same(form: DescriptionFormat, folder: Path) -> None:
    """A file gives the same robot each time: its digest decides which results belong together."""
    path = _example(form, folder)
    require(_read(form, path)[0] == _read(form, path)[0], "the second reading is not the first")


@check("description-damage")
def damage_is_refused(form: DescriptionFormat, folder: Path) -> None:
    """A file that is cut is refused with a UsageError."""
    path = _example(form, folder)
    content = path.read_bytes()
    path.write_bytes(content[: len(content) * 2 // 3])
    _require_refused(form, path, {}, "a file that is cut")


@check("description-arguments")
def unknown_arguments_are_refused(form: DescriptionFormat, folder: Path) -> None:
    """An argument that the file does not take is refused with a UsageError: a slip would change nothing."""
    _require_refused(form, _example(form, folder), {"no_such_argument_": "1"}, "an argument that it does not take")


@check("description-writes-nothing")
def nothing_is_written(form: DescriptionFormat, folder: Path) -> None:
    """`read` leaves the folder of its file as it is: it writes nothing there."""
    path = _example(form, folder)
    before = {file: file.stat().st_mtime_ns for file in folder.rglob("*")}
    _read(form, path)
    require(before == {file: file.stat().st_mtime_ns for file in folder.rglob("*")}, "it writes into the folder")


DESCRIPTION_CHECKS: tuple[Check, ...] = (
    settings_are_frozen,
    settings_survive_json,
    its_own_files_are_recognised,
    a_urdf_comes_of_it,
    names_are_those_of_the_urdf,
    reading_twice_is_the_same,
    damage_is_refused,
    unknown_arguments_are_refused,
    nothing_is_written,
)


def _example(form: DescriptionFormat, folder: Path) -> Path:
    """The format's own example, which may be read although some formats are programs."""
    path = form.write_example(folder)
    allow_programs([str(path)])
    return path


def _read(form: DescriptionFormat, path: Path) -> tuple[Description, Urdf]:
    described = form.read(path, {}, {})
    return described, parse_urdf(described.urdf)


def _require_refused(form: DescriptionFormat, path: Path, arguments: Mapping[str, str], what: str) -> None:
    try:
        form.read(path, arguments, {})
    except UsageError:
        return
    except HarnessError as error:
        raise AssertionError(f"{what} is refused with {type(error).__name__}, no UsageError") from error
    raise AssertionError(f"{what} is read")
