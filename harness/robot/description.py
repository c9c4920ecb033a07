"""Descriptions of robots that are no URDF: what a reader of one gives, and which registered reader takes a file."""

import re
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

from harness.errors import UsageError, reason_of
from harness.files.bounded import open_regular
from harness.registry.choice import Choice, Registry
from harness.registry.spec import blamed_on

DESCRIPTIONS = "descriptions"
HEAD_BYTES = 65_536
"""The bytes of a file's beginning that `DescriptionFormat.recognises` is given: licences may stand before all else."""
MOST_BYTES = 256 * 2**20
"""The most bytes of a file that is looked at: one may hold its meshes."""


@dataclass(frozen=True)
class Description:
    """A robot as a reader has understood it.

    Attributes:
        urdf: It as the text of a URDF. Names of meshes in it are absolute, or start at the file's folder.
        tip: The link that the author of the file calls the tool's frame; None where nothing is called so.
        home: The author's resting pose by the names of joints, [rad] or [m]; empty where there is none.
        home_origin: Where that pose stands, in words.
        speeds: What to know where robot.toml gives no speeds, because the format has no place for them; or empty.
        warnings: What else to know about how the file was read, a line each.
    """

    urdf: str
    tip: str | None = None
    home: Mapping[str, float] = field(default_factory=dict)
    home_origin: str = ""
    speeds: str = ""
    warnings: tuple[str, ...] = ()


class DescriptionFormat(Protocol):
    """A frozen dataclass that reads the robots of one format.

    A reader opens files that anybody may have written. It reads within bounds and writes nothing.
    """

    def recognises(self, path: Path, head: bytes) -> bool:
        """Whether a file is of this format. Reads little, and raises nothing.

        Args:
            path: The file.
            head: Its first `HEAD_BYTES` bytes.
        """

    def read(self, path: Path, arguments: Mapping[str, str], packages: Mapping[str, Path]) -> Description:
        """The robot in a file of this format.

        Args:
            path: The file.
            arguments: What the robot.toml gives as `arguments`.
            packages: The folders of ROS packages that it gives as `meshes`, by name; that of the name '' holds others.

        Raises:
            UsageError: The file cannot be read, or the format has no such argument.
        """

    def write_example(self, folder: Path) -> Path:
        """Write a small arm of this format into an empty folder, for the contract kit; the path of its file."""


FOREIGN: Mapping[str, str] = {
    r"\.xacro\n|[^\n]*\n.*<xacro:": "xacro has to be expanded: pip install 'fd100-harness[xacro]', and give this file "
    "again; or xacro arm.urdf.xacro > arm.urdf, and give that",
    r"[^\n]*\n.*<mujocoinclude\b": "it is a part of an MJCF. Give the file that includes it",
    r"[^\n]*\n.*<mujoco\b": "an MJCF is read by MuJoCo: pip install 'fd100-harness[mujoco]', and give this file again",
    r"\.(sdf|world)\n|[^\n]*\n.*<sdf\b": "an SDF is not read. Give the URDF or the xacro file that it was made of; "
    "where there is none, ROS's sdformat_urdf makes one",
    r"\.usd[acz]?\n": "a USD is not read. Give the URDF that it was made of, or export one: the URDF exporter of Isaac "
    "Sim",
    r"[^\n]*\nPK\x03\x04": "it is an archive. Unpack it, and give the URDF in it",
}
"""What to do with a file that no reader takes, by an expression for the suffix of its name, a line break, its head."""


def read_description(
    path: Path, arguments: Mapping[str, str], packages: Mapping[str, Path], registry: Registry
) -> Description | None:
    """What the registered reader of a file understands.

    Args:
        path: The file; no URDF.
        arguments: What the robot.toml gives as `arguments`.
        packages: What it gives as `meshes`.
        registry: Has the readers.

    Returns:
        None where no reader recognises the file, and nothing is known of it: it may be a URDF that is damaged.

    Raises:
        UsageError: The file cannot be read, or is of a format that nothing reads here; says what to do.
    """
    with open_regular(path, MOST_BYTES) as file:
        head = file.read(HEAD_BYTES)
    for name in registry.names(DESCRIPTIONS):
        spec = registry.get(DESCRIPTIONS, name)
        if spec.missing:
            continue
        reader: DescriptionFormat = Choice(name).build(registry, DESCRIPTIONS)
        with blamed_on(spec, "it read a robot"):
            if reader.recognises(path, head):
                try:
                    return reader.read(path, arguments, packages)
                except (OSError, UnicodeDecodeError) as error:
                    raise UsageError(f"{path}: cannot be read ({reason_of(error)}). Correct it.") from error
    described = f"{path.suffix.lower()}\n".encode() + head
    for pattern, remedy in FOREIGN.items():
        if re.match(pattern.encode(), described, re.DOTALL):
            raise UsageError(f"{path}: {remedy}.")
    return None
