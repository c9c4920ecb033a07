"""What is timed beside what: one line of a table of speeds."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, Literal, Self, TypeAlias, get_args

Kind: TypeAlias = Literal["simulators", "algorithms", "peers"]
KINDS: tuple[Kind, ...] = get_args(Kind)


@dataclass(frozen=True)
class Entry:
    """One thing that is timed beside what it is built on, or beside what others have.

    Attributes:
        kind: `simulators`: a simulator and its env beside the bare engine. `algorithms`: a training beside one by the
            bare library. `peers`: either of them beside what others have.
        of: What kind of plugin: `simulators` or `algorithms`.
        name: The plugin with its parameters, ``mujoco:substeps=40``.
        num_envs: How many arms are stepped at once; of a simulator.
        peer: Its name, of an entry of the kind `peers`; else empty.
    """

    kind: Kind
    of: Literal["simulators", "algorithms"]
    name: str
    num_envs: int = 1
    peer: str = ""

    @property
    def title(self) -> str:
        """What to call it."""
        if self.peer:
            return f"{self.name} beside {self.peer}"
        if self.of == "algorithms":
            return self.name
        return f"{self.name}, {self.num_envs:,} env{'s' if self.num_envs > 1 else ''}"

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """The entry that `to_json` told."""
        return cls(**data)


@dataclass(frozen=True)
class Setting:
    """What all entries of a run have in common.

    Attributes:
        robot: Name or path; None: the task's.
        task: With its parameters.
        steps: Environment steps of one training, of `algorithms`.
        budget: About how long the turns of one round of an entry take, [s].
    """

    robot: str | None = None
    task: str = "fd100-reach"
    steps: int = 256
    budget: float = 3.0

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return asdict(self)

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Self:
        """The setting that `to_json` told."""
        return cls(**data)
