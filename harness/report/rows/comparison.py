"""What comparisons say, and measures of behaviour, as text that the terminal, the page and the summary share."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

from harness.eta.amounts import listed, trainings_text
from harness.eta.behaviour_change import Change, Quantity
from harness.eta.equal import equal_sentences
from harness.eta.headline import (
    Answer,
    Text,
    count_seeds,
    count_trainings,
    format_number,
    interval_text,
    percentage,
    points,
)
from harness.eta.index import NOTHING
from harness.eta.manner import DETERMINISTIC, EVALUATION, LAST_FIFTH, STOCHASTIC, WHOLE
from harness.eta.swaps import p_text
from harness.record.file_forms import Status
from harness.record.plan_file import EXPERIMENT
from harness.report.rows import Fact, Grid
from harness.report.rows.ratios import value_rows
from harness.results import Results
from harness.results.choosing import Choosing
from harness.results.comparison import Comparison, StepChange, pools_of, still_to_come
from harness.results.metrics import Counted
from harness.results.results import standing_of, told_manifests
from harness.results.trainings import Alone, Stages
from harness.text import command_text, shortened

SAME_STEPS = "0, same steps"
"""In place of an interval where both robots take the same steps: nothing is estimated."""
SHOWN = 60
"""The most characters that are shown of the reason why a metric failed."""
HEADINGS = ("", "baseline", "proposed", "difference", "random", "better", "p", "result")


class BehaviourRow(NamedTuple):
    """One measure of the trained policies and of random actions, ready to print."""

    name: str
    baseline: str
    proposed: str
    difference: str
    random: str
    better: str
    p: str
    result: str


def behaviour_grids(comparison: Comparison) -> list[Grid]:
    """A grid for each manner in which behaviour was measured, the one that decides first."""
    manners = dict.fromkeys([comparison.manner, *(change.measure.manner for change in comparison.measured.changes)])
    grids = [_grid(comparison, manner) for manner in manners]
    return [grid for grid in grids if grid.rows]


def shown_changes(comparison: Comparison, manner: str) -> list[Change]:
    """The measures that have a value, those that decide first; below them those whose metric failed for every seed."""
    first, found = comparison.measured.deciding, comparison.measured.changes_of(manner)
    known = [
        replace(it, low=None, high=None) if is_same(comparison, it) else it for it in found if not is_undefined(it)
    ]
    known.sort(key=lambda change: first.index(change.name) if change.name in first else len(first))
    return [*known, *(it for it in found if it.reason and is_undefined(it))]


def is_undefined(change: Change) -> bool:
    """Whether the measure has a value under neither reward."""
    return (change.baseline, change.proposed) == (None, None)


def is_same(comparison: Comparison, change: Change) -> bool:
    """Whether there is no difference because both robots take the same steps, bit for bit."""
    return comparison.measured.same_steps and change.difference == 0.0


def behaviour_row(change: Change) -> BehaviourRow:
    """The row of a measure. If its metric failed for all seeds, the reason stands in place of the values.

    Args:
        change: The values of the measure.
    """
    name, text = measure_name(change.measure), text_of(change.measure)
    if change.reason and is_undefined(change):
        told = f"n/a ({shortened(change.reason, SHOWN)})"
        return BehaviourRow(name, told, *(NOTHING,) * 3, change.measure.better, NOTHING, "")
    return BehaviourRow(
        name,
        text(change.baseline),
        text(change.proposed),
        _difference(change, is_share=text is percentage),
        text(change.random),
        change.measure.better,
        p_text(change.corrected),
        change.direction,
    )


def along_grid(comparison: Comparison) -> Grid:
    """What each evaluation on the way hints at. None of them decides; the last row is the end of the trainings."""
    name = next(iter(comparison.measured.deciding), "").replace("_rate", "").replace("_", " ")
    headings = ("", f"{name}: baseline", "proposed", "difference", "exploratory")
    manner = comparison.own_manner
    moments = [*comparison.measured.along, StepChange(comparison.group.steps, comparison.measured.changes_of(manner))]
    rows = [_moment_row(comparison, moment) for moment in moments] if comparison.measured.along else []
    return Grid(headings, rows, [], f"Along the budget of training, {manner}")


def seeds_grid(comparison: Comparison) -> Grid:
    """What single seeds say where a mean may hide it, in the manner that decides."""
    headings = ("over seeds", "middle half: baseline", "proposed", "chance that a run is better")
    rows: list[tuple[str, ...]] = []
    for change in comparison.measured.changes_of(comparison.manner):
        if change.improvement is not None:
            middles = map(text_of(change.measure), change.middles)
            rows.append((measure_name(change.measure), *middles, f"{change.improvement:.0%}"))
    return Grid(headings, rows, [])


def _grid(comparison: Comparison, manner: str) -> Grid:
    rows: list[tuple[str, ...]] = []
    notes = []
    for change in shown_changes(comparison, manner):
        row = behaviour_row(change)
        rows.append(row._replace(difference=SAME_STEPS) if is_same(comparison, change) else row)
        notes += [_note(change)] if any(change.without) and not is_undefined(change) else []
    return Grid(HEADINGS, rows, notes, _title(comparison, manner))


def _note(change: Change) -> str:
    why = f" ({shortened(change.reason, SHOWN)})" if change.reason else ""
    name, (ours, theirs) = change.name.replace("_", " "), change.counts
    compared = count_seeds(ours) if ours == theirs else f"{count_seeds(ours)} against {theirs}"
    return f"{name}: {compared} compared, {sum(change.without)} without a value{why}"


def _title(comparison: Comparison, manner: str) -> str:
    """How the policies acted, and how many episodes were seen."""
    episodes = comparison.measured.episodes.get(manner)
    if episodes is None:
        return f"Behaviour {manner}"
    seen = count_of(comparison, manner, episodes)
    if manner in (DETERMINISTIC, STOCHASTIC):
        return f"Behaviour of the trained policies, {manner}, {seen} per seed"
    where = where_text(comparison, manner)
    # trainings need not have the same number of episodes
    return f"Behaviour {manner}, {f'{seen} or more per seed {where}'.rstrip()}"


def _moment_row(comparison: Comparison, moment: StepChange) -> tuple[str, ...]:
    """The row of an evaluation, with what it hints at."""
    decisive = next((change for change in moment.changes if change.name in comparison.measured.deciding[:1]), None)
    told = behaviour_row(decisive) if decisive else None
    values = (told.baseline, told.proposed, told.difference) if told else (NOTHING,) * 3
    return (f"after {moment.steps:,} steps", *values, moment.answer)


def measure_name(measure: Quantity) -> str:
    """The name of a measure, with its unit."""
    name, unit = measure.title or measure.name.replace("_", " "), measure.unit
    return f"{name} [{unit}]" if unit and unit not in name.split() else name


def text_of(measure: Quantity) -> Text:
    """The function that writes values of a measure: as a percentage if it is a share, else as a number."""
    return percentage if measure.is_share and not measure.unit else format_number


def _difference(change: Change, is_share: bool) -> str:
    """The interval of proposed - baseline."""
    told = interval_text(change, text=points if is_share else format_number)
    return f"{told} pp" if is_share and told != NOTHING else told


ALONE_HEADINGS = ("an episode", "start", "end", "evaluation", "random")
ALONE = (
    "Means over trainings. Start and end are the first and the last tenth of the episodes of each training, evaluation "
    "those of the final policies. Nothing is compared: whether another reward would teach more, or the same, cannot be "
    "seen here."
)


def size_text(alone: Alone) -> str:
    """How many trainings there are, and how long they are."""
    count = len(alone.seeds)
    if count == 1:
        return f"1 training, {alone.group.steps:,} steps"
    return f"{count} trainings, {alone.group.steps:,} steps each"


def alone_grid(alone: Alone, most: int | None = None) -> Grid:
    """The pay, then a row for each measure; of `most` measures at most, or of all, each with its interval below it."""
    rows: list[tuple[str, ...]] = []
    for stages in (alone.paid, *alone.behaviour[:most]):
        values = (stages.start, stages.end, stages.evaluation, stages.random)
        told = value_rows(measure_name(stages.measure), values, text_of(stages.measure))
        rows += told[:1] if most else told
    return Grid(ALONE_HEADINGS, rows, [])


def story(alone: Alone) -> str:
    """Pay against behaviour over the training, in a sentence; empty where it is not known."""
    told = {"pay of an episode": alone.paid, **{measure_name(it.measure): it for it in alone.behaviour[:1]}}
    ways = [f"the {name} {_way(it)}" for name, it in told.items() if it.start.value is not None]
    return f"Over the trainings: {'; '.join(ways)}." if ways else ""


def beside(results: Results, alone: Sequence[Alone]) -> str:
    """The command that trains another reward beside one that stands alone; empty where no experiment made it."""
    if not alone or results.is_temporary or not results.is_experiment:
        return ""
    place = results.folder / EXPERIMENT
    command = command_text("harness", "run", place, "--reward", "OTHER", "--out", results.folder)
    return f"{command}{results.plugin_flags}"


def _way(stages: Stages) -> str:
    text = text_of(stages.measure)
    return f"from {text(stages.start.value)} to {text(stages.end.value)}"


SYMBOLS = {
    Answer.HELPS: "▲",
    Answer.HURTS: "▼",
    Answer.LEARNS_FASTER: "»",
    Answer.LEARNS_SLOWER: "«",
    Answer.MIXED: "±",
    Answer.NO_DIFFERENCE: "=",
    Answer.NEITHER_LEARNS: "0",
    Answer.AHEAD: "△",
    Answer.BEHIND: "▽",
    Answer.CANNOT_TELL: "?",
    Answer.INTERIM: "…",
}
"""They tell answers apart without colour."""
LEGEND = ", ".join(f"{symbol} {answer.value}" for answer, symbol in SYMBOLS.items())
"""What the symbols mean."""


def word_of(answer: Answer) -> str:
    """The answer as a badge shows it."""
    return answer.value.upper()


def badge_of(answer: Answer) -> str:
    """The class that colours an answer on a page."""
    return answer.name.lower().replace("_", "-")


BETWEEN = " · "


UNLIKE_STARTS = "The policies did not meet the same starts, so that luck with them is part of the difference."
EPISODES = Counted("episode")
NO_REWARD = "No reward enters the success rate and the other measures of behaviour."
TESTS = (
    "HELPS and HURTS stand where the interval of a measure that decides leaves out 0. It counts one training more than "
    "were seen, at the end that speaks most against the word. It has 95%; 98% from the second look on, and more where "
    "several questions are asked. AHEAD and BEHIND SO FAR are about these trainings alone, and need a p of at most "
    "0.05: labels are shuffled among the runs, and p says how often chance alone gives a difference as large. It is "
    "corrected for all questions about the {subject}. All other comparisons are exploratory: their intervals have 95%, "
    "and their p is corrected among themselves."
)
INTERIM_TESTS = (
    "Trainings are missing, so nothing is tested about the {subject}: how they end is an outcome too, and to look at "
    "results again and again gives luck more chances. Every p on the way is exploratory. Each 95% confidence interval "
    "is over seeds, and holds by itself."
)


def rewards_text(comparison: Comparison) -> str:
    """Which rewards were compared."""
    told = f"{comparison.proposed} against {comparison.baseline}"
    return f"{told}, trained again with other seeds (A/A, the null control)" if comparison.is_control else told


def seeds_text(seeds: Sequence[int]) -> str:
    """How many seeds, and which."""
    noun = "seed" if len(seeds) == 1 else "seeds"
    return f"{len(seeds)} {noun} ({', '.join(map(str, seeds))})" if seeds else "no seed"


def compared_text(comparison: Comparison) -> str:
    """How many trainings are compared: which seeds, where both rewards have the same ones."""
    counts = comparison.counts
    is_even = counts == (len(comparison.seeds),) * 2
    return seeds_text(comparison.seeds) if is_even else trainings_text(comparison.names, counts)


def what_decides(results: Results) -> str:
    """What the tests hold for; where trainings are missing that there are none."""
    return (INTERIM_TESTS if still_to_come(results.combinations) else TESTS).format(subject=results.subject)


def interim_text(results: Results) -> str:
    """A line that trainings are missing, which stands before everything else; empty where none is."""
    missing = still_to_come(results.combinations)
    is_planned = results.is_experiment and not results.plan.note
    how = " harness run --until decided plans for looks on the way." if is_planned else ""
    if results.account.missing:
        how = " harness report --details says which failed, and how to leave them out."
    return f"{interim_line(missing)}{how}" if missing else ""


def interim_line(missing: str) -> str:
    """The same, of a clause that says how many."""
    return f"Interim: {missing}. Nothing here says yet what is better or worse."


def beside_answer(comparison: Comparison) -> list[str]:
    """What a reader of the answer has to know at once, a sentence or two each."""
    starts = "" if comparison.measured.same_starts else UNLIKE_STARTS
    return [line for line in (*comparison.not_maximised, scale_text(comparison), starts) if line]


def scale_text(comparison: Comparison) -> str:
    """Why behaviour differs where both rewards ask for the same, k times as loudly; empty where that is not so."""
    found, names = comparison.number.rescaling, comparison.names
    if found is None or comparison.is_control or not comparison.headline.decided_by:
        return ""
    if not found.is_ruler or (found.factor, found.offset) == (1.0, 0.0):
        return ""
    return (
        f"{names.proposed} {found.formula(names.baseline)}: both rewards prefer the same steps. The learner reacts to "
        "the size of the pay, so its scale decides here, and not what is paid for."
    )


def count_of(comparison: Comparison, manner: str, count: int) -> str:
    """So many episodes, or what stands for them in a manner."""
    return f"{count:,} {comparison.measured.counted.get(manner, EPISODES).noun}{'s' * (count != 1)}"


def where_text(comparison: Comparison, manner: str) -> str:
    """The steps of which a manner tells; empty if it is all that are asked about."""
    over = comparison.measured.counted.get(manner, EPISODES).over
    if over is None:
        return ""
    begin, end = (f"{it:,.0f}" for it in over)
    return f"after {end} steps" if begin == end else f"from {begin} to {end} steps"


def basis_text(comparison: Comparison) -> str:
    """Which episodes the verdict rests on, where that needs saying; else empty."""
    is_measured = comparison.has_trainings and comparison.measured.changes
    if not is_measured or comparison.manner in (DETERMINISTIC, STOCHASTIC):
        return ""
    count = comparison.measured.episodes[comparison.manner]
    told = f"{count_of(comparison, comparison.manner, count)} or more of each seed"
    where = where_text(comparison, comparison.manner)
    rests = "will rest" if comparison.headline.answer is Answer.INTERIM else "rests"
    if comparison.manner.startswith(EVALUATION):
        return f"The verdict {rests} on evaluations of the final policies, {f'{told} {where}'.rstrip()}."
    ends = [it.reason for it in comparison.measured.changes_of(LAST_FIFTH) if it.reason]
    unknown = f" Of the end nothing is known: {ends[0]}." if comparison.manner == WHOLE and ends else ""
    return (
        f"The verdict {rests} on the training itself, {told} {where or comparison.manner}: evaluations of the final "
        f"policies were not recorded for all seeds. harness.evaluate_policy records one.{unknown}"
    )


def advice(results: Results, comparison: Comparison) -> str:
    """What to run for an answer, in a line; empty where `until_decided` is."""
    command = until_decided(results, comparison)
    return command and f"For an answer with the fewest trainings: {command}"


def until_decided(results: Results, comparison: Comparison) -> str:
    """The command that trains until there is an answer; empty if no number of seeds gives one, or none is needed."""
    ruling, pool, seeds = comparison.answer.ruling, comparison.answer.pool, comparison.seeds
    asked = pool if pool is not None and ruling is not None and ruling.is_held else comparison
    if asked.headline.seeds_to_decide is None or seeds != tuple(range(len(seeds))) or comparison.is_control:
        return ""
    if results.is_temporary or not results.is_experiment:
        return ""
    return again_text(results, " --until decided")


def again_text(results: Results, until: str = "") -> str:
    """The command that trains an experiment again, in a new folder."""
    command = command_text("harness", "run", results.folder / EXPERIMENT, "--out", "NEW")
    return f"{command}{until}{results.plugin_flags}"


def claims_text(comparison: Comparison) -> str:
    """How much is tested and how much explored; empty without a seed."""
    ruling, claims = comparison.answer.ruling, comparison.answer.claims
    if not comparison.has_trainings or comparison.headline.answer is Answer.INTERIM:
        return ""
    asked = 1 if ruling is None else ruling.asked
    verb = "is" if asked == 1 else "are"
    together = "" if asked == 1 else " together"
    questions = f"{asked} question{'s' * (asked != 1)} about the {comparison.group.subject} {verb} tested{together}."
    others = f"{claims} exploratory comparison{'s' * (claims != 1)} do{'es' * (claims == 1)} not affect the verdict."
    return f"{questions} {others}"


def count_cells(results: Results) -> str:
    """How many cells there are, or recordings, and how many ended in which way."""
    counts = Counter(manifest.status for manifest in told_manifests(results))
    noun = "cell" if results.is_experiment else "recorded training"
    noun += "s" * (counts.total() != 1)
    order: tuple[Status, ...] = ("done", "failed", "damaged", "skipped", "pending", "not needed")
    ended = [f"{counts[status]} {status}" for status in order if counts[status]]
    return f"{counts.total()} {noun}: {', '.join(ended)}" if ended else "No cells"


def remarks_on_cells(results: Results) -> list[str]:
    """A line for each cell that failed or is damaged; one for all that were skipped or wait for the same reason.

    Then one for trainings that are equal bit for bit, and what else to keep in mind of the trainings.
    """
    lines = [results.plan.note] if results.plan.note else []
    for manifest in (*results.failed, *results.damaged):
        lines.append(f"{manifest.status}: {manifest.cell.title}: {manifest.reason}")
    waiting = [it for it in told_manifests(results) if it.status in ("skipped", "pending", "not needed")]
    counts = Counter((manifest.status, manifest.reason) for manifest in waiting)
    lines += [f"{count} {status}: {reason}" for (status, reason), count in counts.items()]
    for group, equal in results.equal.items():
        where = f"{group.title}: " if len(results.groups) > 1 else ""
        lines += [f"{where}{line}." for line in equal_sentences(equal)]
    return [*lines, *(f"{line}." for line in results.notes), *filter(None, [looks_text(results)])]


def question(results: Results) -> str:
    """What the report answers."""
    if results.alone and not results.combinations:
        return f"What did {' and '.join(dict.fromkeys(it.reward for it in results.alone))} pay for?"
    labels = dict.fromkeys(comparison.proposed for comparison in results.combinations)
    proposed = [label for label in labels if label != results.baseline]  # that would be A/A
    if results.choosing is not None:
        names = results.choosing.candidates
        among = f"{', '.join(names[:-1])} and {names[-1]}"
        return f"Which of {among} makes the {results.subject} behave better than {results.baseline}?"
    verb, subject = ("Does", "a reward") if not proposed else ("Does", f"the reward {proposed[0]}")
    if len(proposed) > 1:
        verb, subject = "Do", f"the rewards {', '.join(proposed[:-1])} and {proposed[-1]}"
    return f"{verb} {subject} make the {results.subject} behave better, or only the numbers bigger?"


POOLED_TITLE = "Over all places"
GROWN = (
    "Seeds were added after {counts} had been trained, and no plan foresaw that. So intervals that decide have 98 %. "
    "AHEAD and BEHIND SO FAR say how often luck alone gets so far."
)

JOINED = (
    "{rewards} came later, when results of other rewards could be seen. All questions are corrected together, so an "
    "earlier answer may have changed. The newest one counts."
)


def pooled_answers(combinations: Sequence[Comparison]) -> list[tuple[str, str]]:
    """The answers over all places, each once: its word, and a sentence."""
    return [(word_of(it.headline.answer), it.headline.robot) for it in pools_of(combinations)]


def grown_text(results: Results) -> str:
    """A warning where a folder has grown by looks that no plan foresaw; else empty."""
    grown = results.plan.terms.grown
    return GROWN.format(counts=listed([count_seeds(seeds) for seeds in grown])) if grown else ""


def joined_text(results: Results) -> str:
    """Which rewards were asked for when results of others could be seen; empty where that is not so."""
    joined = results.plan.terms.joined
    return JOINED.format(rewards=listed(joined)) if joined else ""


def looks_text(results: Results) -> str:
    """How an experiment with looks stands; empty for others."""
    standing = standing_of(results)
    if standing is None:
        return ""
    told = "One of several rewards is chosen, with a budget that was set before the first training"
    if not isinstance(standing, Choosing):
        seeds = ", ".join(map(str, standing.terms.looks))
        told = f"Looks at {seeds} seeds (trained until decided; planned before the first training)"
    return f"{told}: {standing.text}."


CHOOSING_TITLE = "How far the candidates went"
CHOOSING = (
    "The worse half of the candidates leaves at each stage, by the mean of their trainings so far. That promises "
    "nothing: one that left may be as good. So the one that went furthest and the baseline train anew, and only these "
    "new trainings are compared."
)
SAID = {
    Answer.CANNOT_TELL: "whether it beats {baseline} cannot be told yet",
    Answer.HELPS: "{name} helps",
    Answer.HURTS: "{name} hurts",
    Answer.AHEAD: "{name} is ahead so far",
    Answer.BEHIND: "{name} is behind so far",
    Answer.NO_DIFFERENCE: "{name} makes no difference",
}


def choosing_facts(results: Results) -> list[Fact]:
    """Who went furthest, and a line for each candidate; none where none is chosen, or before the first stage is over.

    The line has the mean of what decides at each stage at which the candidate was there.
    """
    found = results.choosing
    if found is None or found.schedule is None or not found.halving.means:
        return []
    measure, is_share, sign = _measure(results)
    means = found.halving.means
    went = dict.fromkeys(name for of in reversed(means) for name in of)
    rungs = found.schedule.rungs[: len(means)]
    headings = ("", *(f"{measure} of {count_trainings(rung.seeds)}" for rung in rungs))

    def shown(value: float | None) -> str:
        return NOTHING if value is None else f"{sign * value:.1%}" if is_share else format_number(sign * value)

    rows = [(name, *(shown(of[name]) if name in of else "" for of in means)) for name in went]
    table = Fact(CHOOSING_TITLE, grids=(Grid(headings, rows, []),))
    return [Fact(_went(results, found)), table, Fact(lines=(CHOOSING,), kind="reading")]


def _went(results: Results, found: Choosing) -> str:
    """Who went furthest, and what is said of it."""
    winner, count = found.halving.furthest, len(found.candidates)
    if winner is None:
        return f"{found.text[:1].upper()}{found.text[1:]}."
    told, fresh = f"{winner} went furthest of {count} ({count_trainings(found.spent)}).", len(found.fresh) // 2
    answers = [it.headline for it in results.pools] or [it.headline for it in results.combinations]
    if not found.is_over or not answers:
        return f"{told} New trainings of it and of {found.baseline} are to tell whether it helps: {fresh} of each."
    answer = answers[0].answer
    said = SAID.get(answer, f"the answer is {word_of(answer)}").format(name=winner, baseline=found.baseline)
    return f"{told} On {fresh} new trainings of each, {said}."


def _measure(results: Results) -> tuple[str, bool, float]:
    """What decides, whether it is a share, and -1 where less of it is better."""
    for of in results.trainings:
        for name in of.deciding[:1]:
            measure = of.quantity(name, "", 1)
            return name.replace("_", " "), measure.is_share, -1.0 if measure.better == "lower" else 1.0
    return "behaviour", False, 1.0
