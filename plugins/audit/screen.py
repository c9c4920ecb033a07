"""What ``harness run --screen`` says of rewards: the short form of an audit."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from harness.authoring.commands import FINISH, pays_of
from harness.screen import CANNOT_TELL, FAILING, NOTHING, Screened, Word

if TYPE_CHECKING:
    from harness.authoring.commands import Cell, Registry


@dataclass(frozen=True)
class Cheats:
    """A screen that moves arms by scripts."""

    def screen(self, cells: "Sequence[Cell]", registry: "Registry") -> Sequence[Screened | None]:
        """See `harness.screen.Screen`."""
        pays = pays_of(cells, registry)
        found = [pays.get((cell.robot, cell.task.label, cell.reward.label)) for cell in cells]
        return [None if it is None else Screened(_word(it.returns, it.success), " ".join(it.verdict)) for it in found]


def _word(returns: Mapping[str, float], success: Mapping[str, float]) -> Word:
    """Whether a movement that reaches the target less often than ``finish`` is paid more."""
    if not returns:
        return CANNOT_TELL
    tempting = [name for name in returns if success[name] < success[FINISH] and returns[name] > returns[FINISH]]
    return FAILING if tempting else NOTHING
