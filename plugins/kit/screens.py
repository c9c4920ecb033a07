"""What a screen of rewards must satisfy. Each check takes the screen and an empty folder."""

from collections.abc import Mapping, Sequence
from contextlib import chdir
from pathlib import Path

from harness.authoring.commands import Cell, Plan, Registry, check_experiment, expand, load_registry, read_given
from harness.screen import WORDS, Screen, Screened

from .contract import Check, check, raise_first_in_folders, require, settings_are_frozen, settings_survive_json

ARM = {"sim": "kinematic", "algo": "random", "baseline": "sparse", "reward": []}
ENVIRONMENT = {"task": "gymnasium:id=CartPole-v1", "algo": "random", "baseline": "none", "reward": ["own"]}
RAISES = '''"""A reward that pays nobody."""


def raises(step):
    """Pay nothing."""
    raise ValueError("no pay today")
'''


def check_screen(screen: Screen, folder: Path | None = None) -> None:
    """Run all `SCREEN_CHECKS`.

    Args:
        screen: To be checked.
        folder: To work in; one for temporary files if None.

    Raises:
        ContractViolation: At the first check that fails.
    """
    raise_first_in_folders(SCREEN_CHECKS, screen, folder)


@check("screen-answers")
def each_cell_has_an_answer(screen: Screen, folder: Path) -> None:
    """`screen` gives one of the four words with a line, or None, of each cell; not None of all, arm and environment."""
    said = list[Screened]()
    for settings in (ARM, ENVIRONMENT):
        cells, answers = _asked(screen, settings, load_registry())
        require(len(answers) == len(cells), f"{len(answers)} answers for {len(cells)} cells")
        said += [answer for answer in answers if answer is not None]
    require(said, "it says nothing, neither of an arm nor of CartPole-v1")
    for word, line in said:
        require(word in WORDS, f"the word {word!r} is none of {', '.join(WORDS)}")
        require(line.strip() and len(line.splitlines()) == 1, f"{line!r} is no line")


@check("screen-again")
def screening_twice_is_the_same(screen: Screen, folder: Path) -> None:
    """A screen that is asked twice says the same, also of the same cells in another order."""
    registry = load_registry()
    cells, answers = _asked(screen, {**ARM, "reward": ["baseline"]}, registry)
    again = screen.screen(cells[::-1], registry)[::-1]
    require(list(answers) == list(again), f"it says {answers!r}, then {again!r}")


@check("screen-raises")
def a_reward_that_raises_stops_nothing(screen: Screen, folder: Path) -> None:
    """A reward that raises has no alarm, and the others are told as without it."""
    path = folder / "raises.py"
    path.write_text(RAISES, encoding="utf-8")
    registry = load_registry(given=read_given([str(path)]))
    alone, both = (_asked(screen, {**ARM, "reward": rewards}, registry) for rewards in ([], ["raises"]))
    told = {cell.reward.label: answer for cell, answer in zip(*both, strict=True)}
    require(told["raises"] is None or told["raises"].word in WORDS[2:], f"it says {told['raises']!r} of what raises")
    sound = {cell.reward.label: answer for cell, answer in zip(*alone, strict=True)}
    require(told["sparse"] == sound["sparse"], f"beside a reward that raises it says {told['sparse']!r} of another")


@check("screen-writes-nothing")
def nothing_is_written(screen: Screen, folder: Path) -> None:
    """`screen` writes no file into the folder where it is run."""
    with chdir(folder):
        _asked(screen, ARM, load_registry())
    require(not any(folder.iterdir()), "it writes into the folder")


SCREEN_CHECKS: tuple[Check, ...] = (
    settings_are_frozen,
    settings_survive_json,
    each_cell_has_an_answer,
    screening_twice_is_the_same,
    a_reward_that_raises_stops_nothing,
    nothing_is_written,
)


def _asked(
    screen: Screen, settings: Mapping[str, object], registry: Registry
) -> tuple[Sequence[Cell], Sequence[Screened | None]]:
    """One cell of each reward, and what it says of them."""
    of_run = {"seeds": [0], "steps": 32, "evaluation_episodes": 1}
    plan: Plan = expand(check_experiment({**settings, **of_run}, "the contract kit"), registry)
    return plan.cells, screen.screen(plan.cells, registry)
