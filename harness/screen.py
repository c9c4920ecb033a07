"""What a screen is: it looks at rewards before anything is trained, and says a word and a line of each."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol, TypeAlias, get_args, runtime_checkable

if TYPE_CHECKING:
    from harness.record.cell import Cell
    from harness.registry.registry import Registry

Word: TypeAlias = Literal["PAYS FOR FAILING", "PAYS FOR LOITERING", "NOTHING FOUND", "CANNOT TELL"]
FAILING, LOITERING, NOTHING, CANNOT_TELL = get_args(Word)
"""What a screen says of a reward. Never "safe": that nothing was found proves nothing."""


class Screened(NamedTuple):
    """What a screen says of one reward."""

    reward: str
    """Its label."""
    where: str
    """The task or environment, with the robot of an arm."""
    word: Word
    line: str
    """The answer in sentences, without the name of the reward."""


@runtime_checkable
class Screen(Protocol):
    """A screen of rewards. Each is a frozen dataclass, built from its parameters."""

    def screen(self, cells: "Sequence[Cell]", registry: "Registry") -> Sequence[Screened]:
        """Look at the rewards of cells that are to be trained.

        Each reward is told once in each place, whatever the seeds, simulators and algorithms. What it cannot say
        anything of, such as an environment where it moves arms, it leaves out. It trains nothing and writes nothing.

        Args:
            cells: What is to be trained, at least one.
            registry: The plugins.
        """
