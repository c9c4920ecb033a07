"""xacro, ROS's macros: the package of that name makes a URDF of them.

Its expressions are Python, and nothing keeps them from more than arithmetic. So a file is only expanded if the user
named it, as a program.
"""

import json
import os
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from errno import EINVAL
from pathlib import Path
from typing import Any

from harness.errors import UsageError, one_line
from harness.files import require_program, run_apart
from harness.robot import Description, package_folders

CPU_SECONDS, MEMORY = 10, 2**29
"""What it may compute, [s], and its bytes of data; a public arm takes one."""
MOST_BYTES = 4 * 2**20
"""The most bytes of what it makes."""
EXAMPLE = """<robot name="example" xmlns:xacro="http://www.ros.org/wiki/xacro">
  <xacro:arg name="length" default="0.3"/>
  <xacro:macro name="segment" params="name parent axis">
    <link name="${name}"/>
    <joint name="${name}_joint" type="revolute">
      <origin xyz="0 0 ${float('$(arg length)')}"/>
      <parent link="${parent}"/><child link="${name}"/><axis xyz="${axis}"/>
      <limit lower="${-pi / 2}" upper="${pi / 2}" velocity="2" effort="0"/>
    </joint>
  </xacro:macro>
  <link name="base"/>
  <xacro:segment name="turret" parent="base" axis="0 0 1"/>
  <xacro:segment name="upper" parent="turret" axis="0 1 0"/>
  <xacro:segment name="fore" parent="upper" axis="0 1 0"/>
</robot>
"""


@dataclass(frozen=True)
class XacroFile:
    """Expands xacro files."""

    def recognises(self, path: Path, head: bytes) -> bool:
        """By the suffix, or an element of xacro."""
        return path.suffix.lower() == ".xacro" or (b"<robot" in head and b"<xacro:" in head)

    def read(self, path: Path, arguments: Mapping[str, str], packages: Mapping[str, Path]) -> Description:
        """The URDF that the file makes with these arguments."""
        require_program(path, f"{path}: a xacro file")
        folders = {name: str(folder.absolute()) for name, folder in packages.items()}
        words = [str(path.absolute()), *map(json.dumps, (dict(arguments), folders))]
        try:
            text = run_apart(__name__, "expanded", *words, cpu_seconds=CPU_SECONDS, memory=MEMORY)
        except UsageError as error:
            raise UsageError(f"{path}: {str(error).rstrip('.')}.") from error
        return Description(text)

    def write_example(self, folder: Path) -> Path:
        """An arm of three joints."""
        path = folder / "example.urdf.xacro"
        path.write_text(EXAMPLE, encoding="utf-8")
        return path


class _Arguments(dict[str, str]):
    """The arguments of a file, and which it asks for; xacro silently takes others too."""

    def __init__(self, given: Mapping[str, str]) -> None:
        super().__init__(given)
        self.asked: set[str] = set()

    def __contains__(self, name: object) -> bool:
        self.asked.add(str(name))
        return super().__contains__(name)

    def __getitem__(self, name: str) -> str:
        self.asked.add(name)
        return super().__getitem__(name)


def expanded(path: str, arguments: str, packages: str) -> str:
    """The URDF that a file makes, in a process of its own.

    Args:
        path: Absolute.
        arguments: What is given by name, as JSON.
        packages: Absolute folders of packages by their names, as JSON.

    Raises:
        UsageError: It makes none.
    """
    import xacro
    from xacro import substitution_args

    guessed: list[str] = []
    given, folders = _Arguments(json.loads(arguments)), {it: Path(at) for it, at in json.loads(packages).items()}

    def find(package: str) -> str:
        """The folder of a package; where there is none, that around the file's: a checkout has any name."""
        found = next(filter(os.path.isdir, package_folders(package, Path(path).parent, folders)), None)
        guessed.extend([package] * (found is None))
        return str(found or Path(path).parents[1])

    substitution_args._eval_find = find  # its own knows ROS's folders only
    sys.addaudithook(_require_regular)
    try:
        robot = xacro.process_file(path, mappings=given, verbosity=0).documentElement
    except Exception as error:  # of expressions that anybody wrote
        raise UsageError(_problem(one_line(error), guessed)) from error
    if unused := sorted(given.keys() - given.asked):
        declared = ", ".join(sorted(given.asked)) or "none"
        raise UsageError(f"it has no argument '{unused[0]}'. Its arguments: {declared}")
    if not robot.getElementsByTagName("link"):
        raise UsageError("it makes no <link>: a file of macros, it seems. Give the one that calls them")
    if len(text := robot.toxml()) > MOST_BYTES:
        raise UsageError(f"it makes {len(text):,} bytes of URDF, {MOST_BYTES:,} are allowed. Make it smaller")
    return str(text)


def _require_regular(event: str, arguments: tuple[Any, ...]) -> None:
    """Called by Python before it opens a file: a pipe would hold it for ever."""
    name = arguments[0] if event == "open" else 0
    if not isinstance(name, int) and os.path.exists(name) and not os.path.isfile(name):
        raise OSError(EINVAL, "it is no regular file", name)


def _problem(said: str, guessed: Sequence[str]) -> str:
    """What to do about what xacro says, and what that is."""
    if "Undefined substitution argument" in said:
        return f'{said}. Give it in a robot.toml beside the file: arguments = {{ name = "value" }}'
    if guessed and "No such file" in said:
        name = guessed[-1]
        return f'$(find {name}) leads nowhere. Say in a robot.toml beside it: meshes = {{ {name} = "FOLDER" }} ({said})'
    return f"xacro cannot expand it: {said}. Correct it"
