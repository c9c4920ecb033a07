"""What a screen is: it looks at rewards before anything is trained, and says a word and a line of each."""

from collections.abc import Sequence
from typing import TYPE_CHECKING, NamedTuple, Protocol

from harness.errors import PluginError, reason_of
from harness.registry.choice import Choice
from harness.registry.spec import Spec, blamed_on

if TYPE_CHECKING:
    from harness.record.cell import Cell
    from harness.registry.choice import Registry

SCREENS = "screens"
FAILING, LOITERING, NOTHING, CANNOT_TELL = WORDS = (
    "PAYS FOR FAILING", "PAYS FOR LOITERING", "NOTHING FOUND", "CANNOT TELL"
)  # fmt: skip
"""What a screen says of a reward. Never "safe": that nothing was found proves nothing."""


class Screened(NamedTuple):
    """What a screen says of one reward in one place."""

    word: str
    """``PAYS FOR FAILING``, ``PAYS FOR LOITERING``, ``NOTHING FOUND`` or ``CANNOT TELL``."""
    line: str
    """The answer in sentences, without the name of the reward."""


class Screen(Protocol):
    """A frozen dataclass, asked by ``harness run --screen``. It trains nothing and writes nothing."""

    def screen(self, cells: "Sequence[Cell]", registry: "Registry") -> Sequence[Screened | None]:
        """Look at rewards; the answers in the order of the cells, None where it has nothing to say of such a place.

        Args:
            cells: What is to be trained: one for each reward in each task or environment.
            registry: The plugins.
        """


class Looked(NamedTuple):
    """What all screens say.

    Attributes:
        said: Of each reward in each place, at least one answer.
        left_out: Screens whose libraries are not installed, a line each.
    """

    said: "tuple[tuple[Cell, Screened], ...]"
    left_out: tuple[str, ...]


def screened(cells: "Sequence[Cell]", registry: "Registry") -> Looked:
    """Ask all registered screens. One that fails cannot tell, and stops nothing.

    Args:
        cells: What is to be trained.
        registry: The plugins.
    """
    first = {(cell.robot, cell.task, cell.reward): cell for cell in reversed(cells)}
    asked, left_out = tuple(reversed(first.values())), list[str]()
    said: list[tuple[Cell, Screened]] = []
    for name in registry.names(SCREENS):
        spec = registry.get(SCREENS, name)
        if spec.missing:
            left_out.append(f"screen '{name}' is left out: it needs {', '.join(spec.missing)}: {spec.remedy}")
            continue
        try:
            answers = _ask(spec, asked, registry)
        except (Exception, SystemExit) as error:  # whatever a plugin raises
            answers = [Screened(CANNOT_TELL, reason_of(error))] * len(asked)
        said += [(cell, answer) for cell, answer in zip(asked, answers, strict=True) if answer is not None]
    told = {cell for cell, _ in said}
    said += [(cell, Screened(CANNOT_TELL, "No screen looks here.")) for cell in asked if cell not in told]
    return Looked(tuple(sorted(said, key=lambda it: asked.index(it[0]))), tuple(left_out))


def _ask(spec: Spec, cells: "Sequence[Cell]", registry: "Registry") -> Sequence[Screened | None]:
    """The answers of one screen.

    Raises:
        PluginError: It fails, or its answers are no answers.
    """
    screen: Screen = Choice(spec.name).build(registry, SCREENS)
    with blamed_on(spec, "rewards were screened"):
        answers = screen.screen(cells, registry)
    if len(answers) != len(cells) or any(it is not None and it.word not in WORDS for it in answers):
        raise PluginError(f"{spec.title} gives {answers!r}: it has to give one of {', '.join(WORDS)} for each cell")
    return answers
