"""What has to hold of trainings before their logs are compared, and what a reader has to know of them."""

from collections.abc import Callable, Iterable, Sequence
from statistics import median

from harness.errors import UsageError
from harness.eta.amounts import listed
from harness.log import Log
from harness.results.logs.trainings import Sorted, Training

NO_STEPS = (
    "An index of steps, I_N or I_P, needs the reward of each environment step, and these logs keep {}. "
    "harness.RecordRewards records it"
)
KEPT = {"episode": "returns of episodes", "point": "means of returns"}
NEARLY_ALL = 0.95
"""The last row of a log may stand this share of the steps before the training's end, as an episode had not ended."""
MOST_TOLD = 8
"""Lines of what logs tell of themselves."""
ROW_IS = {"step": "a step", "episode": "an episode", "point": "a point of a curve"}
FLAG = "--sort '{reward}/{seed}' says how their names are made, --as FORMAT reads one format alone"


def require_comparable(found: Sorted, *, is_told: bool = False) -> None:
    """Check that trainings are of one environment and algorithm, kept in one way; and that each reward taught several.

    Args:
        found: The trainings.
        is_told: Whether the user said which they are: a reward may then have taught one.

    Raises:
        UsageError: They are not; says what was found, and the flags that say it otherwise.
    """
    trainings = found.trainings
    _require_one(trainings, lambda it: it.logs[0].facts.env, "mixes trainings in several envs", "Name one env's folder")
    algorithm = "mixes trainings by several algorithms"
    _require_one(trainings, lambda it: it.logs[0].facts.algorithm, algorithm, "Name one algorithm's folder")
    for training in trainings:
        if len(training.logs) > 1 and training.logs[0].facts.unit == "step":
            raise UsageError(
                f"{training.shown} has {len(training.logs)} logs of the steps of one training, which are not joined. "
                "--sort '{reward}/{seed}' says that each is a training"
            )
    _require_one(trainings, _unit_of, "cannot compare logs of several kinds", FLAG)
    counts = {name: sum(it.reward == name for it in trainings) for name in found.rewards}
    single = [name for name, count in counts.items() if count < 2]
    if single and len(counts) > 1 and not is_told:
        more = f" and {len(single) - 3} more" if len(single) > 3 else ""
        alone = f"There is one training alone of {listed([*single[:3]])}{more}, and chance cannot be told from one"
        batch = next((it for it in trainings if it.reward in single and len(it.logs) > 1), None)
        if batch:
            raise UsageError(
                f"{alone}: the {len(batch.logs)} files in {batch.shown} are environments of one training, as their "
                "episodes end in step. --sort '{reward}/{seed}' says that each file is a training"
            )
        raise UsageError(f"By the names of their files these are {found.sentence}. {alone}: {FLAG}")


def _unit_of(training: Training) -> str:
    facts = training.logs[0].facts
    thinned = f", {facts.thinned}" if facts.thinned else ""
    return f"{facts.unit}s of {facts.format}{' of evaluations' * facts.evaluation}{thinned}"


def _require_one(trainings: Iterable[Training], value_of: Callable[[Training], str], problem: str, remedy: str) -> None:
    found: dict[str, Training] = {}
    for training in trainings:
        if value_of(training):
            found.setdefault(value_of(training), training)
    if len(found) > 1:
        told = ", ".join(f"{value} ({training.reward}: {training.shown})" for value, training in found.items())
        raise UsageError(f"The folder {problem}: {told}. {remedy}")


def without_short(found: Sorted) -> Sorted:
    """The trainings of which all rows are there that their logs declare; and a line for each other one.

    Raises:
        UsageError: None is left.
    """
    told = {training: _shortfall(training) for training in found.trainings}
    whole = tuple(training for training, short in told.items() if not short)
    lines = [f"{training.shown} is left out: it has {short}" for training, short in told.items() if short]
    if not whole:
        raise UsageError(f"No training has all of its rows: {'. '.join(lines[:3])}")
    return found._replace(trainings=whole, notes=(*found.notes, *lines))


def _shortfall(training: Training) -> str:
    rows = [len(log) for log in training.logs]
    if not sum(rows):
        return f"no {training.logs[0].facts.unit}"
    for log, count in zip(training.logs, rows, strict=True):
        declared = log.facts.declared.get(f"{log.facts.unit}s", count)
        if count != declared:
            return f"{count:,} {log.facts.unit}s, and declares {declared:,}"
        steps = int(log["time"].max()) * len(training.logs) if "time" in log else 0
        asked = max(log.facts.asked, log.facts.declared.get("steps", 0))
        if steps and steps < NEARLY_ALL * asked:
            return f"{steps:,} of {asked:,} steps"
    return ""


def budget_notes(trainings: Sequence[Training], steps: Sequence[int], noun: str) -> list[str]:
    """Trainings that went on after the shortest had ended.

    Args:
        trainings: All of them.
        steps: How long each was.
        noun: What is counted, ``steps`` or ``episodes``.
    """
    shortest = min(steps)
    longer = [it for it in steps if it > shortest]
    if not longer:
        return []
    last = trainings[steps.index(shortest)]
    broke_off = ". Leave it out if it broke off" if 2 * shortest < median(steps) else ""
    return [
        f"All are cut to the {shortest:,} {noun} of the shortest, {last.shown}: {len(longer)} of {len(steps)} went on, "
        f"to {max(longer):,} at most{broke_off}"
    ]


def facts_notes(logs: Sequence[Log]) -> list[str]:
    """What logs tell of themselves, each line once: how they were thinned, and what to keep in mind."""
    kinds = dict.fromkeys((log.facts.format, log.facts.unit) for log in logs)
    counts = {name: sum(log.facts.format == name for log in logs) for name, _ in kinds}
    read = [f"Read: {counts[name]} of {name}, a row is {ROW_IS[unit]}" for name, unit in kinds]
    thinned = dict.fromkeys(log.facts.thinned for log in logs if log.facts.thinned)
    told = dict.fromkeys(note for log in logs for note in log.facts.notes)
    lines = [*read, *thinned, *told]
    more = len(lines) - MOST_TOLD
    return [
        *lines[:MOST_TOLD],
        *([f"The logs tell {more} lines more of themselves, such as: {lines[-1]}"] if more > 0 else []),
    ]


def no_steps_notes(logs: Sequence[Log]) -> tuple[str, ...]:
    """Why there is no eta of steps."""
    units = dict.fromkeys(log.facts.unit for log in logs if log.facts.unit in KEPT and not log.facts.evaluation)
    return tuple(NO_STEPS.format(KEPT[unit]) for unit in units)
