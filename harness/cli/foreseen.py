"""What a run would do, as a terminal shows it."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from harness.text import LONGEST_MESSAGE

if TYPE_CHECKING:
    from harness.experiment.foresee import Foreseen
    from harness.record.cell import Cell

UNITS = ("B", "KB", "MB", "GB", "TB")
SHOWN_SEEDS = LONGEST_MESSAGE // 10


def foreseen_lines(found: "Foreseen") -> Iterator[str]:
    """The plan: where, how many, what is not run and why, what is, and what it takes."""
    yield f"Folder: {found.folder} ({'new' if found.is_new else 'exists, the run goes on there'})"
    total = len(found.done) + len(found.to_do) + found.left + len(found.skipped)
    of_run = {"done": len(found.done), "to do": len(found.to_do)}
    counts = {**of_run, "not in this run": found.left, "skipped": len(found.skipped)}
    is_most = bool(found.looks) or found.is_choosing
    yield f"{'At most ' if is_most else ''}{total} cells: " + ", ".join(
        f"{count} {noun}" for noun, count in counts.items() if count
    )
    for reason, count in Counter(reason for _, reason in found.skipped).items():
        yield f"skipped: {count}: {reason}"
    if found.looks:
        yield _looks(found)
    if found.is_choosing:
        yield from _choosing(found)
    else:
        yield from (f"done: {line}" for line in _by_combination(found.done, lists_seeds=not found.looks))
        yield from (f"to do: {line}" for line in _by_combination(found.to_do, lists_seeds=not found.looks))
    if found.to_do:
        yield from _evaluations(found.to_do[0], found.horizon)
        yield f"Time: {_time(found)}"
        yield f"Disk: {f'not known: {found.unknown}' if found.bytes is None else _size(found.bytes)}"
    yield "Nothing is written."


def _looks(found: "Foreseen") -> str:
    """When a run with looks asks for the answer. Of its cells, those at the end are the most that there can be."""
    first = found.looks[0] * len({replace(it, seed=0) for it in (*found.done, *found.to_do)})
    seeds = ", ".join(map(str, found.looks))
    return f"Looks: at {seeds} seeds of each. The first takes {first} cells. The run ends with the answer"


def _choosing(found: "Foreseen") -> Iterator[str]:
    """Who is trained, and how often: which cells these are is known when the worse half leaves."""
    yield f"Candidates: {', '.join(found.candidates)}"
    if found.schedule is None:
        yield "The first training of each tells how many there is time for"
        return
    rungs = ", ".join(
        f"{'the better ' * bool(at)}{rung.candidates} with {rung.seeds} training{'s' * (rung.seeds != 1)} each"
        for at, rung in enumerate(found.schedule.rungs)
    )
    yield f"In each place: {rungs}. Then {found.schedule.fresh} new ones of the one that is left, and of the baseline"


def _by_combination(cells: Sequence["Cell"], *, lists_seeds: bool) -> Iterator[str]:
    """A line for each simulator, algorithm and reward, with its seeds: which, or how many."""
    seeds: dict[str, list[int]] = {}
    for cell in cells:
        title = " · ".join((cell.place.label, cell.learner, cell.reward.label))
        seeds.setdefault(title, []).append(cell.seed)
    for title, these in seeds.items():
        if not lists_seeds:
            yield f"{title}: {len(these)} {'seed' if len(these) == 1 else 'seeds'}"
            continue
        shown = ", ".join(map(str, these[:SHOWN_SEEDS])) + (" ..." if len(these) > SHOWN_SEEDS else "")
        yield f"{title}: {'seed' if len(these) == 1 else f'{len(these)} seeds:'} {shown}"


def _evaluations(cell: "Cell", horizon: int) -> Iterator[str]:
    """How long episodes may be where nothing but an environment ends them: every cell of a run has the same horizon."""
    if cell.cut_after is not None:
        episodes = f"{cell.evaluation_episodes:,} episodes of each policy"
        is_own = 0 < horizon <= cell.cut_after
        most = (
            f"of at most {horizon:,} steps" if is_own else f"cut after {cell.cut_after:,} steps if it goes on so long"
        )
        yield f"Evaluations: {episodes}, each {most}"


def _time(found: "Foreseen") -> str:
    if found.seconds is None:
        return f"not known: {found.unknown}"
    most = "at most " if found.looks or found.is_choosing else ""
    return f"{most}{about(found.seconds)}, {min(found.at_once, len(found.to_do))} at once, {found.basis}"


def about(seconds: float) -> str:
    """A duration as text: ``about 40 s``, ``about 3 min``, ``about 2 h 10 min``."""
    return f"about {_rounded(seconds)}"


def left_text(seconds: float, *, at_most: bool = False) -> str:
    """The time that is left as text, ``about 3 min left``; where less may do, ``at most 3 min left``."""
    return f"{'at most' if at_most else 'about'} {_rounded(seconds)} left"


def _rounded(seconds: float) -> str:
    """To 5 seconds below 100 seconds, to minutes below 100 minutes, to 10 minutes below 10 hours."""
    if seconds < 9.5:
        return f"{max(round(seconds), 1)} s"
    if seconds < 97.5:
        return f"{5 * round(seconds / 5)} s"
    if seconds < 97.5 * 60:
        return f"{round(seconds / 60)} min"
    hours, tens = divmod(round(seconds / 600), 6)
    if hours >= 10:
        return f"{round(seconds / 3600)} h"
    return f"{hours} h {10 * tens} min" if tens else f"{hours} h"


def _size(count: float) -> str:
    """A size as text, ``about 1.2 MB``."""
    power = 0
    while count >= 1000.0 and power < len(UNITS) - 1:
        count, power = count / 1000.0, power + 1
    return f"about {count:.3g} {UNITS[power]}"
