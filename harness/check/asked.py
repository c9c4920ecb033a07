"""What ``harness check`` was asked to check."""

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any, Self

from harness.registry.given import PluginFile, is_class_name, read_given


@dataclass(frozen=True)
class Asked:
    """A plugin or a robot, as the user named it. Nothing of it has been imported.

    Attributes:
        name: A registered name, with parameters or without: ``arp:k2=2``; of a robot also a path.
        kind: ``rewards`` or ``reward`` and so on; None: the kind that has the name.
        robot: The arm that a simulator or a task is checked with; None: fd100, or the task's own.
        files: Plugin files that were given by hand, with their text.
        classes: Classes that were given by hand, as ``module:Class``.
    """

    name: str
    kind: str | None = None
    robot: str | None = None
    files: tuple[PluginFile, ...] = ()
    classes: tuple[str, ...] = ()

    def to_json(self) -> dict[str, Any]:
        """Plain data; `from_json` gives the same back."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """What `to_json` told."""
        files = tuple(map(PluginFile.from_json, data["files"]))
        return cls(**{**data, "files": files, "classes": tuple(data["classes"])})


def read_plugins(given: Sequence[str]) -> tuple[tuple[PluginFile, ...], tuple[str, ...]]:
    """What ``--plugin`` names: the files, which are read, and the classes, which are not imported.

    Raises:
        UsageError: A file is not there or cannot be read, or two have one name.
    """
    classes = tuple(dict.fromkeys(text for text in given if is_class_name(text)))
    files = read_given([text for text in given if text not in classes])
    return tuple(file for file in files if isinstance(file, PluginFile)), classes
