"""`robot.toml`: the numbers of an arm that its URDF has no place for.

Every key may be left out. Units are in the keys: degrees for joints that turn, metres for joints that slide.
"""

import json
import math
import os
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol

from harness.errors import UsageError
from harness.registry.toml_file import read_toml
from harness.robot.packages import locate
from harness.robot.urdf import LARGEST, Vector
from harness.text import shortened

FILE = "robot.toml"
SHOWN = 100
"""Characters of a value that is refused."""
SHOWN_NAMES = 5
TEXT_KEYS = ("name", "urdf", "end_effector")

Quantity = Literal["home", "max_speed", "max_acceleration"]
Motion = Literal["turning", "sliding"]
JOINT_KEYS: Mapping[Quantity, Mapping[Motion, str]] = {
    "home": {"turning": "home_deg", "sliding": "home_m"},
    "max_speed": {"turning": "max_speed_deg_s", "sliding": "max_speed_m_s"},
    "max_acceleration": {"turning": "max_acceleration_deg_s2", "sliding": "max_acceleration_m_s2"},
}
"""The keys that hold one value per joint of a motion: a list in the order of the chain, or a table by joint names."""
SERVO = "servo"
"""The table of the drives; see `harness.robot.joint_limits`."""
ARGUMENTS = "arguments"
"""The table of texts that a description takes which is no URDF: of a xacro file what it calls arguments."""
RANGE_KEYS: Mapping[Motion, str] = {"turning": "range_deg", "sliding": "range_m"}
"""The same, with two values per joint."""
BASE, TOOL, FIXED, CHAIN, MESHES = "base", "tool", "fixed", "chain", "meshes"
"""What the arm stands on and holds, and where it begins and ends; see `harness.robot.robot`."""
KEYS = (
    *TEXT_KEYS,
    *(BASE, TOOL, FIXED, CHAIN, MESHES),
    *(key for keys in (*JOINT_KEYS.values(), RANGE_KEYS) for key in keys.values()),
    *(SERVO, ARGUMENTS),
)


class Mover(Protocol):
    """A joint that moves, as far as the keys are concerned."""

    @property
    def name(self) -> str: ...

    @property
    def kind(self) -> str: ...


class Form(NamedTuple):
    """What a joint's value has to be.

    Attributes:
        fits: Whether a value is one.
        one: It in words.
        many: Several of them.
        example: One.
    """

    fits: Callable[[object], bool]
    one: str
    many: str
    example: str


@dataclass(frozen=True)
class RobotSettings:
    """What a robot.toml or a table of it says, or the lack of one.

    Attributes:
        path: The file.
        entries: Its keys and values.
        place: The file and, of a table, its name: what an error begins with.
        installed: The arm's file as a robot.toml elsewhere names it, where the arm is an installed package's; nobody
            should write beside it.
    """

    path: Path
    entries: Mapping[str, Any] = field(default_factory=dict)
    place: str = ""
    installed: str = ""

    def __post_init__(self) -> None:
        """The file is the place where nothing else is said."""
        object.__setattr__(self, "place", self.place or str(self.path))

    @property
    def to_write(self) -> str:
        """Where a key has to be written, in words."""
        if not self.installed:
            return str(self.path)
        return f"a {FILE} of your own with urdf = {json.dumps(self.installed)}"

    def text(self, key: str) -> str | None:
        """The value of one of `TEXT_KEYS`; None where it is left out."""
        return self.entries.get(key)

    def arguments(self) -> Mapping[str, str]:
        """The texts of `ARGUMENTS` by name; empty where it is left out.

        Raises:
            UsageError: It is no table of texts.
        """
        given = self.entries.get(ARGUMENTS, {})
        if not isinstance(given, dict) or not all(isinstance(value, str) for value in given.values()):
            raise UsageError(
                f'{self.place}: {ARGUMENTS} is {_shown(given)}. Give a table of texts, {{ name = "value" }}.'
            )
        return given

    def texts(self, key: str, count: int) -> list[str] | None:
        """The value of a key that holds a list of so many texts; None where it is left out.

        Raises:
            UsageError: It is none.
        """
        given = self.entries.get(key)
        if given is None or (isinstance(given, list) and len(given) == count and all(map(_is_text, given))):
            return given
        raise UsageError(f"{self.place}: {key} is {_shown(given)}. Give a list of {count} texts, in quotes.")

    def vector(self, key: str) -> Vector:
        """The value of a key that holds three numbers; zeros where it is left out.

        Raises:
            UsageError: They are not three finite numbers.
        """
        given = self.entries.get(key, [0.0, 0.0, 0.0])
        if not isinstance(given, list) or len(given) != 3 or not all(map(_is_finite_number, given)):
            raise UsageError(f"{self.place}: {key} is {_shown(given)}. Give a list of three finite numbers.")
        return float(given[0]), float(given[1]), float(given[2])

    def folders(self) -> dict[str, Path]:
        """Where `meshes` says that packages lie, by their names; that of all others has the name ''.

        Raises:
            UsageError: It is neither a text nor a table of texts, or there is no such folder.
        """
        given = self.entries.get(MESHES, {})
        table = {"": given} if isinstance(given, str) else given
        if not isinstance(table, dict) or not all(map(_is_text, table.values())):
            raise UsageError(
                f"{self.place}: {MESHES} is {_shown(given)}. Give a folder in quotes, or a table of folders by package."
            )
        return {package: self._folder(name) for package, name in table.items()}

    def _folder(self, name: str) -> Path:
        folder = locate(name, self.path.parent, self.place)
        if not os.path.isdir(folder):  # no error, whatever the name
            raise UsageError(
                f"{self.place}: {MESHES} names '{shortened(name, SHOWN)}': no folder '{folder}'. Name one."
            )
        return folder

    def values(self, quantity: Quantity, joints: Sequence[Mover]) -> list[float | None]:
        """One value per joint, in radians or metres and seconds; None where it is left out.

        Args:
            quantity: Which.
            joints: Those that move, in the order of the chain.

        Raises:
            UsageError: There is not one finite number for each joint of a motion.
        """
        numbers = self.numbers(JOINT_KEYS[quantity], joints)
        return [
            math.radians(value) if value is not None and motion_of(joint) == "turning" else value
            for joint, value in zip(joints, numbers, strict=True)
        ]

    def ranges(self, joints: Sequence[Mover]) -> list[tuple[float, float] | None]:
        """Smallest and largest position of each joint, in radians or metres; None where they are left out.

        Args:
            joints: Those that move, in the order of the chain.

        Raises:
            UsageError: There are not two finite numbers, the lower one first, for each joint of a motion.
        """
        given = {motion: self._list(key, motion, joints, RANGE) for motion, key in RANGE_KEYS.items()}
        pairs = [(next(given[motion_of(joint)]), motion_of(joint)) for joint in joints]
        return [
            pair if pair is None or motion == "sliding" else (math.radians(pair[0]), math.radians(pair[1]))
            for pair, motion in pairs
        ]

    def numbers(self, keys: Mapping[Motion, str], joints: Sequence[Mover]) -> list[float | None]:
        """One value per joint as it is written; None where it is left out.

        Args:
            keys: Of the joints of each motion.
            joints: Those that move, in the order of the chain.

        Raises:
            UsageError: There is not one finite number for each joint of a motion.
        """
        given = {motion: self._list(key, motion, joints, NUMBER) for motion, key in keys.items()}
        found = [next(given[motion_of(joint)]) for joint in joints]
        return [None if number is None else float(number) for number in found]

    def number(self, key: str, default: float) -> float:
        """The value of a key that holds one number.

        Raises:
            UsageError: It is no finite number.
        """
        value = self.entries.get(key, default)
        if not _is_finite_number(value):
            raise UsageError(f"{self.place}: {key} is {_shown(value)}. Give a finite number.")
        return float(value)

    def table(self, name: str, keys: Sequence[str]) -> "RobotSettings | None":
        """One of its tables; None where it is left out.

        Args:
            name: Of the table.
            keys: Those that it may have.

        Raises:
            UsageError: It is no table, or has another key.
        """
        if name not in self.entries:
            return None
        entries = self.entries[name]
        if not isinstance(entries, dict):
            raise UsageError(f"{self.place}: {name} is {_shown(entries)}. Write a table: [{name}], and its keys below.")
        place = f"{self.place}: [{name}]"
        _check_keys(place, entries, keys)
        return RobotSettings(self.path, entries, place)

    def _list(self, key: str, motion: Motion, joints: Sequence[Mover], form: Form) -> Any:
        """An iterator over the values of a key, None where it is left out, without end where all are."""
        names = [joint.name for joint in joints if motion_of(joint) == motion]
        values = self.entries.get(key)
        if values is None:
            return iter([None] * len(names))
        if isinstance(values, dict):
            return iter(self._by_name(key, motion, values, names, form))
        if not isinstance(values, list) or not all(map(form.fits, values)):
            raise UsageError(
                f"{self.place}: {key} is {_shown(values)}. Give a list of {len(names)} {form.many}, one per "
                f"{motion} joint, or a table of joints by name, {{ {toml_key(names[0] if names else 'joint')} = "
                f"{form.example} }}."
            )
        if len(values) != len(names):
            raise UsageError(
                f"{self.place}: {key} has {len(values)} values for {len(names)} {motion} joints. Give one per joint."
            )
        return iter(values)

    def _by_name(
        self, key: str, motion: Motion, values: Mapping[str, Any], names: Sequence[str], form: Form
    ) -> list[Any]:
        """One value per joint of a table; None for a joint that it leaves out."""
        unknown = sorted(values.keys() - set(names))
        if unknown:
            given = ", ".join(f"'{shortened(name, SHOWN)}'" for name in unknown[:SHOWN_NAMES])
            allowed = ", ".join(f"'{name}'" for name in names) or "none"
            raise UsageError(f"{self.place}: {key} names {given}. The {motion} joints of the arm: {allowed}.")
        for name, value in values.items():
            if not form.fits(value):
                raise UsageError(f"{self.place}: {key} of '{name}' is {_shown(value)}. Give {form.one}.")
        return [values.get(name) for name in names]


def read_settings(path: Path) -> RobotSettings:
    """The robot.toml at `path`.

    Raises:
        UsageError: It cannot be read, has a key that none has, or no text where text belongs.
    """
    entries = read_toml(path, "robot file")
    _check_keys(str(path), entries, KEYS)
    for key in entries.keys() & set(TEXT_KEYS):
        if not _is_text(entries[key]):
            raise UsageError(f"{path}: {key} is {_shown(entries[key])}. Give a text that is not empty, in quotes.")
    return RobotSettings(path, entries)


def _check_keys(place: str, entries: Mapping[str, Any], keys: Sequence[str]) -> None:
    unknown = sorted(entries.keys() - set(keys))
    if unknown:
        raise UsageError(f"{place}: unknown {', '.join(unknown)}. The keys are {', '.join(keys)}.")


def motion_of(joint: Mover) -> Motion:
    """How a joint that moves does."""
    return "sliding" if joint.kind == "prismatic" else "turning"


def toml_key(name: str) -> str:
    """A name as TOML takes it before a ``=``."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)


def shown(value: float, joint: Mover) -> str:
    """A joint's position, speed or acceleration in the unit of robot.toml."""
    return f"{value if motion_of(joint) == 'sliding' else math.degrees(value):g}"


def _is_finite_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST


def _is_range(value: object) -> bool:
    return isinstance(value, list) and len(value) == 2 and all(map(_is_finite_number, value)) and value[0] < value[1]


def _is_text(value: object) -> bool:
    return isinstance(value, str) and bool(value)


NUMBER = Form(_is_finite_number, "a finite number", "finite numbers", "1")
RANGE = Form(
    _is_range, "two finite numbers, the lower one first", "pairs [lower, upper] of finite numbers", "[-90, 90]"
)


def _shown(given: object) -> str:
    return shortened(repr(given), SHOWN)
