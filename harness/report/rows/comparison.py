"""What a comparison says, as sentences that the terminal and the page share."""

from collections import Counter
from collections.abc import Sequence

from harness.eta.amounts import trainings_text
from harness.eta.equal import equal_sentences
from harness.eta.headline import Answer
from harness.eta.manner import DETERMINISTIC, EVALUATION, LAST_FIFTH, STOCHASTIC, WHOLE
from harness.record.file_forms import Status
from harness.record.plan_file import EXPERIMENT
from harness.report.rows.pools import grown_text, joined_text, looks_text
from harness.results import Results
from harness.results.comparison import Comparison, still_to_come
from harness.results.measured import Counted
from harness.results.standing import told_manifests
from harness.text import command_text

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
    how = " harness run --until decided plans for looks on the way." if results.is_experiment else ""
    if results.account.missing:
        how = " harness report --details says which failed, and how to leave them out."
    return f"{interim_line(missing)}{how}" if missing else ""


def interim_line(missing: int) -> str:
    """The same, of so many trainings."""
    told = f"training{'s are' if missing != 1 else ' is'} missing"
    return f"Interim: {missing:,} {told}. Nothing here says yet what is better or worse."


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


def basis_text(comparison: Comparison) -> str:
    """Which episodes the verdict rests on, where that needs saying; else empty."""
    is_measured = comparison.has_trainings and comparison.measured.changes
    if not is_measured or comparison.manner in (DETERMINISTIC, STOCHASTIC):
        return ""
    count = comparison.measured.episodes[comparison.manner]
    told = f"{count_of(comparison, comparison.manner, count)} or more of each seed"
    where = comparison.measured.counted.get(comparison.manner, EPISODES).where
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
    told = [text for text in (joined_text(results), grown_text(results), looks_text(results)) if text]
    return [*lines, *(f"{line}." for line in results.notes), *told]


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
