"""What ``harness run --screen`` says of rewards: the short form of an audit."""

from collections.abc import Sequence
from contextlib import closing
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

from pydantic import Field

from harness.cli.output import pays_of
from harness.errors import reason_of
from harness.executor import Screened
from harness.experiment.screening import CANNOT_TELL, FAILING
from harness.payoff.rollout import FINISH

if TYPE_CHECKING:
    from harness.record import Cell
    from harness.registry import Registry
    from harness.report import Payoffs

    from .search.finding import Finding


@dataclass(frozen=True)
class Cheats:
    """Movements of an arm by scripts, then in any task or environment a search, shorter than that of an audit.

    Attributes:
        steps: About so many steps are taken for each reward of an arm, whose episodes are played side by side.
        steps_elsewhere: The same in an environment.
        starts: From so many starts.
    """

    steps: Annotated[int, Field(gt=0, description="Steps of the search for each reward of an arm.")] = 200_000
    steps_elsewhere: Annotated[int, Field(gt=0, description="The same in an environment.")] = 100_000
    starts: Annotated[int, Field(gt=0, description="Starts that are searched.")] = 4

    def screen(self, cells: "Sequence[Cell]", registry: "Registry") -> Sequence[Screened | None]:
        """See `harness.executor.Screen`."""
        pays = pays_of(cells, registry)
        return [
            self._look(cell, pays.get((cell.robot, cell.task.label, cell.reward.label)), registry) for cell in cells
        ]

    def _look(self, cell: "Cell", scripted: "Payoffs | None", registry: "Registry") -> Screened:
        """What the search says of one reward, and then the scripts; their word counts where the search cannot tell."""
        told = [] if scripted is None else scripted.verdict
        try:
            found = self._search(cell, registry)
        except (Exception, SystemExit) as error:  # whatever a plugin raises
            word, first = CANNOT_TELL, [f"Not searched: {reason_of(error)}."]
        else:
            word, first = found.word, [f"{found.strength}." if found.strength else "", found.lines[0]]
        if word == CANNOT_TELL and scripted is not None and scripted.returns:
            # a movement that reaches the target less often than `finish` is paid more
            paid, success = scripted.returns, scripted.success
            if any(success[name] < success[FINISH] and paid[name] > paid[FINISH] for name in paid):
                word = FAILING
        return Screened(word, " ".join(filter(None, (*first, *told))))

    def _search(self, cell: "Cell", registry: "Registry") -> "Finding":
        from .search.find import Search, find_in
        from .search.place import GAMMA_OF_ARM, blamed_at, places_in_environment, places_on_task, world_at
        from .transitions.audit_rewards import GAMMA

        task, reward, discount = cell.task, cell.reward, cell.algorithm.named.get("gamma")
        if cell.is_in_environment:
            asked = Search(self.steps_elsewhere, self.starts)
            (place,) = places_in_environment(registry, task, [reward.label], float(discount or GAMMA))
        else:
            asked = Search(self.steps, self.starts)
            (place,) = places_on_task(registry, [reward], task.label, cell.robot, None, float(discount or GAMMA_OF_ARM))
        with blamed_at(place, registry), closing(world_at(place, registry)) as world:
            return find_in(world, asked)
