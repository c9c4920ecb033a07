"""xacro, ROS's macros: the package of that name makes a URDF of them.

Its expressions are Python, and nothing keeps them from more than arithmetic. So a file is only expanded if the user
named it, as a program.
"""

import contextlib
import io
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from harness.errors import UsageError, one_line
from harness.registry.allowed import is_allowed_program
from harness.robot.description import Description
from harness.robot.source import package_folders
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

    def read(self, path: Path, arguments: Mapping[str, str]) -> Description:
        """The URDF that the file makes with these arguments."""
        if not is_allowed_program(path):
            raise UsageError(
                f"{path}: a xacro file is a program, and a file or a folder names it: it is not expanded for that. If "
                f"you trust it, add --allow-program {command_text(str(path))}"
            )
        import xacro

        guessed: list[str] = []
        silent = io.StringIO()
        try:
            with contextlib.redirect_stderr(silent), contextlib.redirect_stdout(silent), _finding(path, guessed):
                document = xacro.process_file(str(path), mappings=dict(arguments), verbosity=0)
        except Exception as error:  # of expressions that anybody wrote
            said = one_line(error)
            raise UsageError(f"{path}: xacro cannot expand it: {said}. {_remedy(said, guessed)}") from error
        if not document.documentElement.getElementsByTagName("link"):
            raise UsageError(f"{path}: it makes no <link>: a file of macros, it seems. Give the one that calls them.")
        return Description(document.documentElement.toxml())

    def write_example(self, folder: Path) -> Path:
        """An arm of three joints."""
        path = folder / "example.urdf.xacro"
        path.write_text(EXAMPLE, encoding="utf-8")
        return path


@contextlib.contextmanager
def _finding(path: Path, guessed: list[str]) -> Iterator[None]:
    """Within it ``$(find PACKAGE)`` leads where ``package://PACKAGE`` does; xacro alone knows ROS's own folders only.

    Args:
        path: The file.
        guessed: Gets the packages of which there is no folder. For these the one around the file's folder is taken, as
            a checkout may be called otherwise.
    """
    from xacro import substitution_args

    def find(package: str) -> str:
        found = next(package_folders(package, path.parent), None)
        guessed.extend([package] * (found is None))
        return str(found or path.absolute().parent.parent)

    kept = substitution_args._eval_find
    substitution_args._eval_find = find
    try:
        yield
    finally:
        substitution_args._eval_find = kept


def _remedy(said: str, guessed: Sequence[str]) -> str:
    """What to do about what xacro says."""
    if "Undefined substitution argument" in said:
        return 'Give it in a robot.toml beside the file: arguments = { name = "value" }.'
    if guessed:
        return f"Name the folder that '{guessed[-1]}' lies in by ROS_PACKAGE_PATH: $(find {guessed[-1]}) is not here."
    return "Correct it."
