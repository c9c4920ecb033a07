"""Turns sorted logs into the trainings of a study, which the same tests compare as recorded trainings."""

from collections import Counter
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TypeAlias

import numpy as np

from harness.arrays import Float
from harness.errors import SchemaError, UsageError
from harness.eta.amounts import listed
from harness.eta.equal import equal_sentences, equal_trainings
from harness.eta.laws import (
    LEAST_POINTS,
    NEAR,
    NEARLY_ALL,
    Account,
    Curves,
    Span,
    counted,
    latest_shared,
    require_direction,
    require_share,
    shortfall_at_begin,
    shortfall_beside,
    within,
)
from harness.eta.manner import EVALUATION, LAST_FIFTH, WHOLE
from harness.log import Log, LogFacts, in_memory
from harness.log.log import BEHAVIOUR, RECORDED, REWARD, SINCE, SUCCESS, TIME, Rows, joined
from harness.record.cell import UNKNOWN_ALGORITHM
from harness.registry.choice import Choice
from harness.results.comparison import Group
from harness.results.logs.labels import LABELS
from harness.results.logs.told import LENGTH, RETURN, SUCCESS_DECIDES, Deciding
from harness.results.logs.trainings import Sorted, Training, digest_of
from harness.results.metrics import Counted
from harness.results.recordings.episodes import LAST_SHARE, Episodes, Points, cut_notes, require_ends
from harness.results.recordings.runs import (
    DIRECTION,
    NO_NAME,
    Run,
    Runs,
    better_of,
    brought,
    quantities_of,
    require_one,
    run_of,
)

NO_STEPS = (
    "An index of steps, I_N or I_P, needs the reward of each environment step, and these logs keep {}. "
    "harness.RecordRewards records it"
)
KEPT = {"episode": "returns of episodes", "point": "means of returns"}
MOST_TOLD = 8
"""Lines of what logs tell of themselves."""
ROW_IS = {"step": "a step", "episode": "an episode", "point": "a point of a curve"}
Other: TypeAlias = tuple[Path, str]
"""A file or a folder of a training of which nothing is read, and why; empty if the user leaves it out."""
FLAG = "--sort '{reward}/{seed}' says how their names are made, --as FORMAT reads one format alone"


def require_comparable(trainings: Sequence[Training]) -> None:
    """Check that trainings are of one environment and algorithm, and kept in one way.

    Raises:
        UsageError: They are not; says what was found, and the flags that say it otherwise.
    """

    def require(told: Callable[[LogFacts], str], problem: str, remedy: str) -> None:
        named = [(told(it.facts), f"{it.reward}: {it.shown}") for it in trainings]
        require_one(named, f"The folder {problem}", remedy)

    require(lambda it: it.env, "mixes trainings in several envs", "Name one env's folder")
    require(lambda it: it.algorithm, "mixes trainings by several algorithms", "Name one algorithm's folder")
    for training in trainings:
        if len(training.logs) > 1 and training.facts.unit == "step":
            raise UsageError(
                f"{training.shown} has {len(training.logs)} logs of the steps of one training, which are not joined. "
                "--sort '{reward}/{seed}' says that each is a training"
            )
    require(_kind_of, "cannot compare logs of several kinds", FLAG)


def _kind_of(facts: LogFacts) -> str:
    kind = f"{facts.unit}s of {facts.format}{' of evaluations' * facts.evaluation}"
    return ", ".join(filter(None, (kind, facts.thinned)))


def account_of(
    trainings: Sequence[Training], other: Iterable[Other] = (), leave_out: Collection[Path] = (), measure: str = ""
) -> Account[Training]:
    """Which trainings are whole, and which are missing; see `harness.eta.laws`.

    Args:
        trainings: Those of which a log was read.
        other: Files and folders of others, and why nothing is read of them.
        leave_out: What the user leaves out.
        measure: What decides, if it is a measure of the logs.

    Raises:
        UsageError: None is whole.
    """
    short = {it: why for it in trainings if (why := _shortfall(it) or _diverged(it, measure))}
    ran = [it for it in trainings if it not in short]
    if ran:
        told, noun = timed(ran)
        of = dict(zip(ran, told, strict=True))
        done = {it: (it.reward, _steps(of[it]), sum(map(len, it.logs))) for it in ran}
        short |= shortfall_beside(done, noun) | shortfall_at_begin({it: _span(of[it]) for it in ran}, noun)
    begun = [*((it, it.place, short.get(it, "")) for it in trainings), *((None, *it) for it in other)]
    account = counted(begun, leave_out)
    if not account.whole:
        raise UsageError(f"No training has all of its rows: {'. '.join(account.lines[:3])}")
    return account


def _diverged(training: Training, measure: str) -> str:
    """Why nothing is known of its end: from some row on the measure that decides is no number."""
    column, evaluated = f"{BEHAVIOUR}{measure}", training.evaluated
    for log in [evaluated] if evaluated is not None and column in evaluated else training.logs:
        known = np.flatnonzero(~np.isnan(log[column])).tolist() if column in log else []
        if known and known[-1] < len(log) - 1:
            return f"{measure} is no number in row {known[-1] + 2:,}, nor in any after it"
    return ""


def _shortfall(training: Training) -> str:
    rows = [len(log) for log in training.logs]
    if not sum(rows):
        return f"it has no {training.facts.unit}"
    for log, count in zip(training.logs, rows, strict=True):
        declared = log.facts.declared.get(f"{log.facts.unit}s", count)
        if count != declared:
            return f"it has {count:,} {log.facts.unit}s, and declares {declared:,}"
        steps = int(log["time"].max()) * len(training.logs) if "time" in log else 0
        asked = max(log.facts.asked, log.facts.declared.get("steps", 0))
        if steps and steps < NEARLY_ALL * asked:
            return f"it has {steps:,} of {asked:,} steps"
    if len(rows) > 1:  # environments that step together end within an episode of one another
        ends = {log.facts.path: log[TIME].max() for log in training.logs}
        first, last = min(ends, key=ends.__getitem__), max(ends.values())
        if ends[first] + max(log[LENGTH].max() for log in training.logs) < NEARLY_ALL * last:
            return f"'{first}' ends after {ends[first]:,.0f} steps, and another environment after {last:,.0f}"
    return ""


def facts_notes(logs: Sequence[Log]) -> list[str]:
    """What logs tell of themselves, each line once: how they were thinned, and what to keep in mind."""
    counts = Counter((log.facts.format, log.facts.unit) for log in logs)
    read = [f"Read: {count} of {name}, a row is {ROW_IS[unit]}" for (name, unit), count in counts.items()]
    thinned = dict.fromkeys(log.facts.thinned for log in logs if log.facts.thinned)
    lines = [*read, *thinned, *dict.fromkeys(note for log in logs for note in log.facts.notes)]
    more = len(lines) - MOST_TOLD
    if more > 0:
        lines[MOST_TOLD:] = [f"The logs tell {more} lines more of themselves, such as: {lines[-1]}"]
    return lines


OWN_ALONE = (
    "each reward paid its own trainings alone, and returns of two rewards are not comparable: every reward has its own "
    "scale"
)


def runs_of(
    found: Sorted,
    deciding: Deciding = SUCCESS_DECIDES,
    other: Iterable[Other] = (),
    leave_out: Collection[Path] = (),
) -> Runs:
    """Sorted trainings that can be compared.

    Args:
        found: The trainings.
        deciding: What decides; ``success`` where it is told, if the user says nothing.
        other: See `account_of`.
        leave_out: What the user leaves out.

    Raises:
        UsageError: They cannot be compared, or the measure is not told.
        SchemaError: A log is damaged.
    """
    require_comparable(found.trainings)
    for training in found.trainings:
        require_ends(training.logs[0])
    logs = [log for it in found.trainings for log in it.all_logs]
    shares = {it.facts.path / it.facts.run: it[f"{BEHAVIOUR}{SUCCESS}"] for it in logs if SUCCESS in it.measures}
    require_share("Success", shares, lambda place: f"'{place}'")
    facts, told = [log.facts for log in logs], list(dict.fromkeys(name for log in logs for name in log.measures))
    measures = _measures(told, logs, deciding)
    account = account_of(found.trainings, other, leave_out, next(iter(measures), ""))
    found = found._replace(trainings=account.whole)
    trainings = found.trainings
    runs, steps, noun = read_trainings(trainings, measures)
    if measures and len(found.rewards) > 1:
        _require_steps(trainings, noun, is_evaluated=all(it.evaluation for it in runs))
    units = dict.fromkeys(it.unit for it in facts if it.unit in KEPT and not it.evaluation)
    # a reward that some training by another one does not know
    is_apart = any(np.isnan(it.episodes.returns.get(name, np.nan)).any() for it in runs for name in found.rewards)
    shortest = min(steps)
    members = {it.key: replace(it, cut=shortest, apart=OWN_ALONE * is_apart) for it in runs}
    return Runs(
        _group(runs, shortest),
        tuple(dict.fromkeys([*found.rewards, *(name for run in runs for name in run.facts.rewards)])),
        quantities_of(measures, runs, facts, deciding),
        members,
        shortest,
        tuple(NO_STEPS.format(KEPT[unit]) for unit in units),
        said=(
            found.sentence + _deciding_text(measures, told, trainings),
            *account.lines,
            *found.notes,
            *facts_notes([log for log in logs if log.facts.format != LABELS]),
            *cut_notes({it.shown: of for it, of in zip(trainings, steps, strict=True)}, noun),
            *equal_sentences(equal_trainings({it.key: it.likeness.digest for it in runs})),
        ),
        counted=_counted(trainings, runs, shortest),
        missing=account.missing,
        offered=measures[1:] if is_named_later(deciding) else (),
    )


def read_trainings(trainings: Sequence[Training], measures: Sequence[str]) -> tuple[list[Run], list[int], str]:
    """Each training with its evaluations up to the end of the shortest, and how long each was, counted in what.

    Raises:
        UsageError: Nothing tells when policies were evaluated.
        SchemaError: A log is damaged.
    """
    told, noun = timed(trainings)
    steps = {it: _steps(it) for it in told}
    until = min(steps.values())
    runs = [_run(it, of, measures) for it, of in steps.items()]
    runs = _at_one_moment(runs, [_evaluations(it, measures, until) for it in steps], until)
    curves = {it: it.episodes for it in runs if isinstance(it.episodes, Points)}
    beside = Curves(tuple(it.curve for it in curves.values()))
    found = [replace(it, episodes=replace(curves[it], beside=beside)) if it in curves else it for it in runs]
    return found, list(steps.values()), noun


def _at_one_moment(runs: Sequence[Run], evaluated: Sequence[Sequence[Run]], steps: int) -> list[Run]:
    """The same, each with its evaluations up to the last that was made when those of all others were.

    Where some have none, each has all of its own. Where there is no such moment in the last fifth, evaluations are
    points of a curve, unless the training itself tells more.
    """
    last: list[int] | None = [len(of) - 1 for of in evaluated]
    if all(evaluated):
        last = latest_shared([[it.facts.after for it in of] for of in evaluated], (1.0 - LAST_SHARE) * steps)
    if last is None:
        both = zip(runs, evaluated, strict=True)
        return [it if len(it.episodes.last) else replace(it, episodes=_curve_of(of)) for it, of in both]
    return [
        replace(it, evaluation=of[place], before=tuple(of[:place])) if of else it
        for it, of, place in zip(runs, evaluated, last, strict=True)
    ]


def _curve_of(evaluated: Sequence[Run]) -> Points:
    """Evaluations as points of a curve, each at its moment."""
    told = [[it.facts.after - 1, *it.whole.returns.values(), *it.whole.behaviour.values()] for it in evaluated]
    found = Episodes.of(evaluated[0].facts, np.array(told, np.float64).T)
    return Points(**vars(found), since=(found.last + 1).astype(np.float64), beside=Curves(()))


def _require_steps(trainings: Sequence[Training], noun: str, *, is_evaluated: bool) -> None:
    """Check that every value of a curve knows which environment steps it averages.

    Raises:
        UsageError: Nobody knows it of one; says what to type.
    """
    if noun == "iterations":
        each = ",".join(f"{name}=N" for name in dict.fromkeys(it.reward for it in trainings))
        raise UsageError(
            f"'{trainings[0].facts.path}' counts iterations of the learner, or calls of a logger, and no environment "
            f"steps, and two rewards may have taken different steps in each. --per-step {each} says how many one is"
        )
    logs = [log for it in trainings for log in it.logs if SINCE in log]
    unknown = next((log for log in logs if np.isnan(log[SINCE]).any()), None)
    if unknown is not None and not is_evaluated:
        raise UsageError(
            f"'{unknown.facts.path}': a value is a mean over the last 100 episodes, and nothing tells how many steps "
            f"these took, so that nobody knows what was at the end. --as {unknown.facts.reader}:episode=N says how "
            "many steps an episode has at most"
        )


def _counted(trainings: Sequence[Training], runs: Sequence[Run], steps: int) -> dict[str, Counted]:
    """By manner, what is counted of these trainings, which are cut to so many steps, and where."""
    curves = [it.episodes.beside for it in runs if isinstance(it.episodes, Points)]
    begins = {WHOLE: 0.0, LAST_FIFTH: (1.0 - LAST_SHARE) * steps} if curves else {}
    found = {manner: Counted("point", within(Span(of, steps), curves[0].known)) for manner, of in begins.items()}
    ends = [it.evaluation.facts.after for it in runs if it.evaluation is not None]
    if ends:
        are_points = any(log.facts.unit == "point" for it in trainings if (log := it.evaluated) is not None)
        over = Span(min(ends), max(ends)) if {*ends} != {steps} else None
        found[EVALUATION] = Counted("point" if are_points else "episode", over)
    return found


def _deciding_text(measures: Sequence[str], told: Sequence[str], trainings: Sequence[Training]) -> str:
    others = [f"`{name}`" for name in told if name not in measures]
    more = f". The logs tell {listed(others)} too: --measure NAME:better=lower lets one decide" if others else ""
    if not measures:
        has_lengths = all(LENGTH in log for it in trainings for log in it.logs)
        return (
            "; only returns are told, and returns of two rewards are not comparable. --labels FILE says which "
            "trainings succeeded"
            + ", --measure length:better=lower lets the length of episodes decide" * has_lengths
            + more
        )
    first = measures[0]
    lacking = sum(not any(f"{BEHAVIOUR}{first}" in log for log in it.all_logs) for it in trainings)
    without = f", which {lacking} of {len(trainings)} trainings do not tell" if lacking and first == SUCCESS else ""
    return f"; {first} decides{without}{more}"


def is_named_later(deciding: Deciding) -> bool:
    """Whether a measure was named that would not decide by itself: then it is one of all that could have been."""
    return deciding.name not in ("", SUCCESS)


def _measures(told: Sequence[str], logs: Sequence[Log], deciding: Deciding) -> tuple[str, ...]:
    """The names of the measures of which it is known which values are better; the one that decides first.

    All that there are, where one of them was named after they were known.
    """
    better = {name: better_of(name, [log.facts for log in logs], deciding) for name in (*told, RETURN, LENGTH)}
    known = sorted((it for it in told if better[it]), key=lambda name: name != SUCCESS)
    named = deciding.name
    if not named:
        return tuple(known) if SUCCESS in known else ()
    if named not in better:
        raise UsageError(f"--measure {named}: the logs tell {', '.join([*told, RETURN, LENGTH])}")
    require_direction(named, better[named], DIRECTION.format(named))
    others = [*told, *[LENGTH] * any(LENGTH in log for log in logs)] if is_named_later(deciding) else []
    return tuple(dict.fromkeys([named, *known, *others]))


def _group(runs: Sequence[Run], steps: int) -> Group:
    """What they share. Policies are evaluated every so many steps, if that is the same in all trainings."""
    env = next((it.facts.env for it in runs if it.facts.env), NO_NAME)
    names = {it.facts.algorithm for it in runs}
    algorithm = UNKNOWN_ALGORITHM if len(names) > 1 or "" in names else Choice(min(names), (), min(names))
    evaluated = [[*it.before, it.evaluation] for it in runs if it.evaluation is not None]
    times, *others = {(0, *(it.facts.after for it in of)) for of in evaluated} or {()}
    every, *gaps = {*np.diff(times).tolist()} if len(times) > 2 and len(evaluated) == len(runs) else {0}
    episodes = min((len(of[-1].episodes.last) for of in evaluated), default=0)
    return brought(env, algorithm, steps, episodes, 0 if others or gaps else every)


# One training


MOST_STEPS = 10**12
"""No training takes more: a larger number tells the time of day."""
TIMES = {TIME: "steps", LENGTH: "steps", "iteration": "iterations"}
"""Columns that tell how much of a training was done, of episodes by their lengths, and what it is counted in."""


def timed(trainings: Sequence[Training]) -> tuple[list[Training], str]:
    """The same trainings, in whose logs ``time`` tells how much was done when each row ended; and what that counts.

    It is what the first of `TIMES` tells that all logs have; else rows are counted.

    Raises:
        UsageError: Nothing tells when policies were evaluated.
        SchemaError: A log is damaged.
    """
    logs = [log for it in trainings for log in it.logs]
    unit = logs[0].facts.unit
    usable = (it for it in TIMES if unit == "episode" or it != LENGTH)
    column = next((it for it in usable if all(it in log for log in logs)), "")
    noun = TIMES.get(column, f"{unit}s")

    def told(log: Log, by: str) -> Log:
        ends = np.asarray(log[by], np.float64) if by else np.arange(1.0, len(log) + 1)
        ends = np.cumsum(ends) if by == LENGTH else ends
        if not (np.diff(ends, append=MOST_STEPS) >= 0.0).all():
            raise SchemaError(f"{log.facts.path}: its rows are not in the order of their {noun}, up to {MOST_STEPS:,}")
        return log.add({TIME: ends})

    def evaluated(log: Log | None) -> Log | None:
        if log is None or log.facts.format == LABELS or unit == "step":
            return log
        moment = TIME if column == LENGTH else column  # the lengths of evaluations are no steps of the training
        if moment not in log:
            raise UsageError(f"'{log.facts.path}' does not tell the {noun} at which it evaluated: move it elsewhere")
        return told(log, moment)

    return [
        replace(it, logs=tuple(told(log, column) for log in it.logs), evaluation=evaluated(it.evaluation))
        for it in trainings
    ], noun


def _steps(training: Training) -> int:
    """How long it was, over all of its environments.

    An episode that had not ended has no row: a policy that was evaluated later than that was trained for longer.
    """
    rows = int(max(log[TIME][-1] for log in training.logs)) * len(training.logs)
    evaluated = training.evaluation
    return rows if evaluated is None or TIME not in evaluated else max(rows, int(evaluated[TIME][-1]))


def _span(training: Training) -> Span:
    """The steps of which the rows of its first log tell; the first row tells of no more than any other one."""
    log = training.logs[0]
    ends = log[TIME]
    apart = log[LENGTH][0] if log.facts.unit == "episode" and LENGTH in log else np.diff(ends).max(initial=0.0)
    return Span(max(0.0, float(ends[0] - apart)) if len(ends) >= LEAST_POINTS else 0.0, float(ends[-1]))


def _run(training: Training, steps: int, measures: Sequence[str]) -> Run:
    """A training of so many steps, without its evaluations."""
    facts = training.facts
    if facts.unit == "step":
        (log,) = training.logs
        return run_of(replace(log, facts=facts), training.seed)
    count = len(training.logs)  # environments of a batch step together
    rows = Rows(joined([_columns(log, count * log[TIME], measures) for log in training.logs]))
    order = np.argsort(rows[TIME], kind="stable")[: 0 if facts.evaluation else None]
    whole = in_memory(replace(facts, path=training.path, evaluation=False), rows.part(order).columns)
    return run_of(whole, training.seed, steps, digest_of(training.logs))


def _evaluations(training: Training, measures: Sequence[str], until: int) -> list[Run]:
    """What policies did in each evaluation up to a step of the training, in order; none beside a log of steps."""
    log = training.evaluated
    if log is None or training.facts.unit == "step":
        return []
    ends = np.full(len(log), float(until)) if log.facts.format == LABELS else log[TIME]
    facts = replace(training.facts, path=log.facts.path, evaluation=True, unit="episode")
    rows = Rows(_columns(log, ends, measures))
    moments, runs = rows[TIME], []
    for after in np.unique(moments[moments <= until * (1.0 + NEAR)]):
        of = rows.part(moments == after)
        run = run_of(in_memory(facts, {**of.columns, TIME: np.arange(1.0, len(of) + 1)}), training.seed, len(of))
        runs.append(replace(run, facts=replace(run.facts, after=int(after))))
    return runs


def _columns(log: Log, ends: Float, measures: Sequence[str]) -> dict[str, Float]:
    """The numbers of a log; NaN of what decides and is not told.

    A row before the first step, such as a first point at 0, counts as one of the first.
    """

    def told(column: str) -> Float:
        return np.asarray(log[column], np.float64) if column in log else np.full(len(ends), np.nan)

    found = {TIME: np.maximum(ends, 1.0)}
    if SINCE in log:
        found[SINCE] = np.where(np.isnan(log[SINCE]), ends, log[SINCE])
    for name in log.rewards or (RECORDED,):
        found[f"{REWARD}{name}"] = told(f"{REWARD}{name}")
    for name in measures:
        column = f"{BEHAVIOUR}{name}"
        other = {RETURN: f"{REWARD}{RECORDED}", LENGTH: LENGTH}.get(name, "")
        found[column] = told(column if column in log else other)
    return found
