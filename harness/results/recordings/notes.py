"""What to keep in mind of recorded trainings that are compared, a line each."""

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from harness.record.recording.facts import OWN_SOURCE
from harness.results.recordings.episodes import count_text, cut_text
from harness.results.recordings.runs import Run, meet_same_starts

UNLIKE_STARTS = (
    "The policies did not meet the same starts: the first observations of their evaluations differ, so that luck with "
    "the starts is part of every difference. An env has to draw everything random from the generator that reset(seed) "
    "seeds, and every evaluation has to begin with the same seed"
)


def notes_on(everything: Sequence[Run], trained: Sequence[str], members: Mapping[tuple[str, int], Run]) -> list[str]:
    """How trainings and evaluations differ in what they were given, or ended early.

    Args:
        everything: All recordings that were read whole, evaluations too.
        trained: The rewards that taught a policy.
        members: The trainings that are compared, by reward and seed.
    """
    runs = list(members.values())
    return [
        *_unclosed(it for it in everything if it.facts.evaluation),
        *_length_notes(runs, min(run.steps for run in runs)),
        *([] if meet_same_starts(runs) else [UNLIKE_STARTS]),
        *_end_notes(trained, members),
        *_code_notes(everything),
        *_bounds_notes(everything),
    ]


def _unclosed(evaluations: Iterable[Run]) -> list[str]:
    """Evaluations that were cut off before recordings told how much was asked for."""
    return [
        f"'{run.path}' is no whole evaluation, perhaps: it is still going on, or was killed, after "
        f"{count_text(len(run.episodes.last), 'episode')}. How many were asked for is not recorded"
        for run in evaluations
        if not run.facts.closed and not run.facts.episodes_asked
    ]


def _length_notes(runs: Iterable[Run], shortest: int) -> list[str]:
    longer = [run.steps for run in runs if run.steps > shortest]
    last = next(run for run in runs if run.steps == shortest)
    told = f"All are cut to the {shortest:,} steps of the shortest, '{last.path}'"
    notes = (
        [f"{told}: {count_text(len(longer), 'training')} went on, for {max(longer):,} steps at most"] if longer else []
    )
    if longer and any(run.evaluation for run in runs):
        notes.append("Evaluations are of policies at the end of their trainings, which were not of one length")
    going = [run for run in runs if not run.facts.closed]
    if going:
        notes.append(f"Still going on, or ended before the recording was closed: {', '.join(map(_quoted, going))}")
    return notes


def _end_notes(trained: Sequence[str], members: Mapping[tuple[str, int], Run]) -> list[str]:
    """Trainings in which no episode ended, and evaluations whose episodes were cut, for each reward that trained."""
    notes = []
    for reward in trained:
        runs = [run for (name, _), run in members.items() if name == reward]
        unended = sum(not len(run.episodes.last) for run in runs)
        if unended:
            told = f"No episode ended in {unended} of {count_text(len(runs), 'training')} by {reward}"
            notes.append(f"{told}: give the environment a time limit")
        evaluations: dict[int, list[Run]] = {}
        for evaluation in (run.evaluation for run in runs if run.evaluation is not None):
            evaluations.setdefault(evaluation.facts.horizon, []).append(evaluation)
        for horizon, some in evaluations.items():
            cut = sum(it.facts.cut for it in some)
            if cut:
                told = cut_text(cut, sum(len(it.episodes.last) for it in some), horizon)
                notes.append(f"Policies trained by {reward}: {told}")
    return notes


def _code_notes(runs: Iterable[Run]) -> list[str]:
    """Rewards and measures that have one name and are not the same."""
    found: dict[str, dict[str, Path]] = {}
    for run in runs:
        for column, source in run.facts.sources.items():
            if source.text and source.text != OWN_SOURCE:
                found.setdefault(column, {}).setdefault(source.text, run.path)
    return [
        f"The code of {column.replace('/', ' ', 1)} is not the same in '{paths[0]}' and '{paths[1]}': its numbers may "
        "not be comparable"
        for column, of in found.items()
        if len(paths := list(of.values())) > 1
    ]


def _bounds_notes(runs: Iterable[Run]) -> list[str]:
    """Measures that left the bounds that their recordings name."""
    left = {
        name: (run.path, bounds)
        for run in runs
        for name, bounds in run.facts.bounds.items()
        if not run.episodes.is_within(name, bounds)
    }
    return [
        f"{name} leaves its bounds, {low:g} to {high:g}, in '{path}': its intervals are not cut to them"
        for name, (path, (low, high)) in left.items()
    ]


def _quoted(run: Run) -> str:
    return f"'{run.path}'"
