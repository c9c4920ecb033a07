"""`robot.toml`: the numbers of an arm that its URDF has no place for.

Every key may be left out. Units are in the keys: degrees for joints that turn, metres for joints that slide.
"""

import json
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

from harness.errors import UsageError
from harness.registry.toml_file import read_toml
from harness.robot.urdf import LARGEST, Joint
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
"""The table of the drives; see `harness.robot.servo`."""
ARGUMENTS = "arguments"
"""The table of texts that a description takes which is no URDF: of a xacro file what it calls arguments."""
KEYS = (*TEXT_KEYS, *(key for keys in JOINT_KEYS.values() for key in keys.values()), SERVO, ARGUMENTS)


@dataclass(frozen=True)
class RobotSettings:
    """What a robot.toml or a table of it says, or the lack of one.

    Attributes:
        path: The file.
        entries: Its keys and values.
        place: The file and, of a table, its name: what an error begins with.
    """

    path: Path
    entries: Mapping[str, Any] = field(default_factory=dict)
    place: str = ""

    def __post_init__(self) -> None:
        """The file is the place where nothing else is said."""
        object.__setattr__(self, "place", self.place or str(self.path))

    def text(self, key: str) -> str | None:
        """The value of one of `TEXT_KEYS`; None where it is left out."""
        return self.entries.get(key)

    def texts(self, key: str) -> Mapping[str, str]:
        """The texts of a table by name; empty where it is left out.

        Raises:
            UsageError: It is no table of texts.
        """
        table = self.entries.get(key, {})
        if not isinstance(table, dict) or not all(isinstance(value, str) for value in table.values()):
            raise UsageError(f'{self.place}: {key} is {_shown(table)}. Give a table of texts, {{ name = "value" }}.')
        return table

    def values(self, quantity: Quantity, joints: Sequence[Joint]) -> list[float | None]:
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

    def numbers(self, keys: Mapping[Motion, str], joints: Sequence[Joint]) -> list[float | None]:
        """One value per joint as it is written; None where it is left out.

        Args:
            keys: Of the joints of each motion.
            joints: Those that move, in the order of the chain.

        Raises:
            UsageError: There is not one finite number for each joint of a motion.
        """
        given = {motion: self._list(key, motion, joints) for motion, key in keys.items()}
        return [next(given[motion_of(joint)]) for joint in joints]

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

    def _list(self, key: str, motion: Motion, joints: Sequence[Joint]) -> Any:
        """An iterator over the values of a key, None where it is left out, without end where all are."""
        names = [joint.name for joint in joints if motion_of(joint) == motion]
        values = self.entries.get(key)
        if values is None:
            return iter([None] * len(names))
        if isinstance(values, dict):
            return iter(self._by_name(key, motion, values, names))
        if not isinstance(values, list) or not all(_is_finite_number(value) for value in values):
            raise UsageError(
                f"{self.place}: {key} is {_shown(values)}. Give a list of {len(names)} finite numbers, one per "
                f"{motion} joint, or a table of joints by name, {{ {toml_key(names[0] if names else 'joint')} = 1 }}."
            )
        if len(values) != len(names):
            raise UsageError(
                f"{self.place}: {key} has {len(values)} values for {len(names)} {motion} joints. Give one per joint."
            )
        return iter([float(value) for value in values])

    def _by_name(self, key: str, motion: Motion, values: Mapping[str, Any], names: Sequence[str]) -> list[float | None]:
        """One value per joint of a table; None for a joint that it leaves out."""
        unknown = sorted(values.keys() - set(names))
        if unknown:
            given = ", ".join(f"'{shortened(name, SHOWN)}'" for name in unknown[:SHOWN_NAMES])
            allowed = ", ".join(f"'{name}'" for name in names) or "none"
            raise UsageError(f"{self.place}: {key} names {given}. The {motion} joints of the arm: {allowed}.")
        for name, value in values.items():
            if not _is_finite_number(value):
                raise UsageError(f"{self.place}: {key} of '{name}' is {_shown(value)}. Give a finite number.")
        return [float(values[name]) if name in values else None for name in names]


def read_settings(path: Path) -> RobotSettings:
    """The robot.toml at `path`.

    Raises:
        UsageError: It cannot be read, has a key that none has, or no text where text belongs.
    """
    entries = read_toml(path, "robot file")
    _check_keys(str(path), entries, KEYS)
    for key in entries.keys() & set(TEXT_KEYS):
        if not isinstance(entries[key], str) or not entries[key]:
            raise UsageError(f"{path}: {key} is {_shown(entries[key])}. Give a text that is not empty, in quotes.")
    return RobotSettings(path, entries)


def _check_keys(place: str, entries: Mapping[str, Any], keys: Sequence[str]) -> None:
    unknown = sorted(entries.keys() - set(keys))
    if unknown:
        raise UsageError(f"{place}: unknown {', '.join(unknown)}. The keys are {', '.join(keys)}.")


def motion_of(joint: Joint) -> Motion:
    """How a joint that moves does."""
    return "sliding" if joint.kind == "prismatic" else "turning"


def toml_key(name: str) -> str:
    """A name as TOML takes it before a ``=``."""
    return name if re.fullmatch(r"[A-Za-z0-9_-]+", name) else json.dumps(name, ensure_ascii=False)


def shown(value: float, joint: Joint) -> str:
    """A joint's position, speed or acceleration in the unit of robot.toml."""
    return f"{value if motion_of(joint) == 'sliding' else math.degrees(value):g}"


def _is_finite_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and abs(value) <= LARGEST


def _shown(given: object) -> str:
    return shortened(repr(given), SHOWN)
