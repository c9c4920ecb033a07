"""xacro, ROS's macros: the package of that name makes a URDF of them.

Its expressions are Python, and nothing keeps them from more than arithmetic. So a file is only expanded if the user
named it, as a program.
"""

import contextlib
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from harness.errors import UsageError, one_line
from harness.registry.allowed import is_allowed_program
from harness.robot import Description
from harness.robot.packages import package_folders
from harness.text import command_text

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
        if not is_allowed_program(path):
            raise UsageError(
                f"{path}: a xacro file is a program, and a file or a folder names it: it is not expanded for that. If "
                f"you trust it, add --allow-program {command_text(str(path))}"
            )
        import xacro

        guessed: list[str] = []
        given = _Arguments(arguments)
        silent = io.StringIO()

        def find(package: str) -> str:
            """The folder of a package; where there is none, that around the file's: a checkout has any name."""
            found = next(package_folders(package, path.parent, packages), None)
            guessed.extend([package] * (found is None))
            return str(found or path.absolute().parent.parent)

        try:
            with contextlib.redirect_stderr(silent), contextlib.redirect_stdout(silent), _finding_by(find):
                document = xacro.process_file(str(path), mappings=given, verbosity=0)
        except Exception as error:  # of expressions that anybody wrote
            raise UsageError(f"{path}: {_problem(one_line(error), guessed)}.") from error
        if unused := sorted(arguments.keys() - given.asked):
            declared = ", ".join(sorted(given.asked)) or "none"
            raise UsageError(f"{path}: it has no argument '{unused[0]}'. Its arguments: {declared}.")
        if not document.documentElement.getElementsByTagName("link"):
            raise UsageError(f"{path}: it makes no <link>: a file of macros, it seems. Give the one that calls them.")
        return Description(document.documentElement.toxml())

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


@contextlib.contextmanager
def _finding_by(find: Callable[[str], str]) -> Iterator[None]:
    """Within it ``$(find PACKAGE)`` is what a function says; xacro alone knows ROS's own folders only."""
    from xacro import substitution_args

    kept = substitution_args._eval_find
    substitution_args._eval_find = find
    try:
        yield
    finally:
        substitution_args._eval_find = kept


def _problem(said: str, guessed: Sequence[str]) -> str:
    """What to do about what xacro says, and what that is."""
    if "Undefined substitution argument" in said:
        return f'{said}. Give it in a robot.toml beside the file: arguments = {{ name = "value" }}'
    if guessed and "No such file" in said:
        name = guessed[-1]
        return f'$(find {name}) leads nowhere. Say in a robot.toml beside it: meshes = {{ {name} = "FOLDER" }} ({said})'
    return f"xacro cannot expand it: {said}. Correct it"
