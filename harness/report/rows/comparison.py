"""What a comparison says, as text: sentences and small grids that the terminal and the page share."""

import math
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from typing import NamedTuple

from harness.eta.amounts import trainings_text
from harness.eta.curve import Kind
from harness.eta.equal import equal_sentences
from harness.eta.headline import Answer, Headline
from harness.eta.index import Index, Ratio
from harness.eta.judge import p_text
from harness.eta.seed_mean import SeedMean
from harness.eta.splits import Decomposition, Split, SplitPath, Splits, SumSplit
from harness.eta.verdict.deals import smallest_p
from harness.record.file_forms import Status
from harness.record.plan_file import EXPERIMENT
from harness.report.answers import word_of
from harness.report.rows.pools import grown_text, joined_text, looks_text
from harness.results import Results
from harness.results.comparison import Comparison, still_to_come
from harness.results.measured import DETERMINISTIC, EVALUATION, STOCHASTIC
from harness.results.overview import NEAR_ZERO, NOTHING
from harness.results.standing import told_manifests
from harness.text import command_text

SCALES = "eta compares two rewards, each on its own scale. It does not say how the {subject} behaves."
UNLIKE_STARTS = "The policies did not meet the same starts, so that luck with them is part of the difference."
SPLIT = (
    "eta = ruler x behaviour. For the ruler both rewards score the same runs. For the behaviour one reward scores the "
    "runs of both trainings."
)
PATHS = (
    "There are two paths: the ruler on the proposed runs with the behaviour under the baseline reward, and the ruler "
    "on the baseline's runs with the behaviour under the proposed reward. Each part is the geometric mean of both. "
    "The interaction is the one ruler divided by the other. It is 1 where both paths say the same."
)
TOTAL = "I_N + I_P is the sum of the whole curve. Its change is ruler + behaviour, also where no ratio is defined."
NO_REWARD = "No reward enters the success rate and the other measures of behaviour."
TESTS = (
    "p says how often chance alone gives a difference as large. The measures that decide are corrected for all "
    "questions that the experiment asks about the {subject}. Everything else is a hint, corrected for all hints. A "
    "result stands only where p is at most 0.05. Each interval is over seeds and holds 95% by itself."
)
INTERIM_TESTS = (
    "The plan is not trained to its end, so nothing is tested about the {subject}: to look at results again and again "
    "gives luck more chances. Every p on the way is a hint. Each interval is over seeds and holds 95% by itself."
)
BETTER = {"eta_N": "below 1", "eta_P": "above 1"}


class Grid(NamedTuple):
    """A small table, ready to print: a name in the first column, then values; notes below."""

    headings: tuple[str, ...]
    rows: list[tuple[str, ...]]
    notes: list[str]
    title: str = ""
    """The title above the grid. As the heading of the names it would wrap."""


def rewards_text(combination: Comparison) -> str:
    """Which rewards were compared."""
    told = f"{combination.proposed} against {combination.baseline}"
    return f"{told}, trained again with other seeds (A/A, the null control)" if combination.is_control else told


def seeds_text(seeds: Sequence[int]) -> str:
    """How many seeds, and which."""
    noun = "seed" if len(seeds) == 1 else "seeds"
    return f"{len(seeds)} {noun} ({', '.join(map(str, seeds))})" if seeds else "no seed"


def compared_text(comparison: Comparison) -> str:
    """How many trainings are compared: which seeds, where both rewards have the same ones."""
    counts = comparison.counts
    is_even = counts == (len(comparison.seeds),) * 2
    return seeds_text(comparison.seeds) if is_even else trainings_text(comparison.names, counts)


def answer_text(headline: Headline) -> str:
    """The answer about the robot, as a badge shows it."""
    return word_of(headline.answer)


def scales_text(subject: str) -> str:
    """What eta does not say, of a ``robot`` or an ``agent``."""
    return SCALES.format(subject=subject)


def what_decides(results: Results) -> str:
    """What the tests hold for; of a plan that is not trained to its end that there are none."""
    return (INTERIM_TESTS if still_to_come(results.combinations) else TESTS).format(subject=results.subject)


def interim_text(results: Results) -> str:
    """A line that the plan is not trained to its end, which stands before everything else; empty where it is."""
    missing = still_to_come(results.combinations)
    return interim_line(missing) if missing else ""


def interim_line(missing: int) -> str:
    """The same, of so many trainings that are still to come."""
    noun = f"training{'s' * (missing != 1)} of the plan {'are' if missing != 1 else 'is'}"
    return f"Interim: {missing:,} {noun} still to come. Nothing here says yet what is better or worse."


def beside_answer(comparison: Comparison) -> list[str]:
    """What a reader of the answer has to know at once, a sentence or two each."""
    starts = "" if comparison.same_starts else UNLIKE_STARTS
    return [line for line in (*comparison.not_maximised, scale_text(comparison), starts) if line]


def scale_text(comparison: Comparison) -> str:
    """Why behaviour differs where both rewards ask for the same, k times as loudly; empty where that is not so."""
    found, names = comparison.rescaling, comparison.names
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
    return f"{count:,} {comparison.counted.get(manner, 'episode')}{'s' * (count != 1)}"


def basis_text(comparison: Comparison) -> str:
    """Which episodes the verdict rests on, where that needs saying; else empty."""
    if not comparison.has_trainings or comparison.manner in (DETERMINISTIC, STOCHASTIC):
        return ""
    count = comparison.episodes[comparison.manner]
    told = f"{count_of(comparison, comparison.manner, count)} or more of each seed"
    rests = "will rest" if comparison.headline.answer is Answer.INTERIM else "rests"
    if comparison.manner.startswith(EVALUATION):
        return f"The verdict {rests} on evaluations of the final policies, {told}."
    return (
        f"The verdict {rests} on the training itself, {told} {comparison.manner}: evaluations of the final policies "
        "were not recorded for all seeds. harness.evaluate_policy records one."
    )


def advice(results: Results, combination: Comparison) -> str:
    """What to run for an answer, in a line; empty where `until_decided` is."""
    command = until_decided(results, combination)
    return command and f"For an answer with the fewest trainings: {command}"


def until_decided(results: Results, combination: Comparison) -> str:
    """The command that trains until there is an answer; empty if no number of seeds gives one, or none is needed."""
    ruling, pool, seeds = combination.ruling, combination.pool, combination.seeds
    asked = pool if pool is not None and ruling is not None and ruling.is_held else combination
    if asked.headline.seeds_to_decide is None or seeds != tuple(range(len(seeds))) or combination.is_control:
        return ""
    if results.is_temporary or not results.is_experiment:
        return ""
    return f"{_run_text(results, 'NEW')} --until decided{results.plugin_flags}"


def again_text(results: Results) -> str:
    """The command that trains an experiment again, in a new folder."""
    return f"{_run_text(results, 'NEW')}{results.plugin_flags}"


def _run_text(results: Results, out: str) -> str:
    return command_text("harness", "run", results.folder / EXPERIMENT, "--out", out)


def claims_text(combination: Comparison) -> str:
    """How many questions and hints there are, and what a test with so many seeds can show; empty without a seed."""
    counts, ruling = combination.counts, combination.ruling
    if not combination.has_trainings or combination.headline.answer is Answer.INTERIM:
        return ""
    asked = 1 if ruling is None else ruling.asked
    smallest = smallest_p(*counts)
    least = f"no p below {smallest:.2g} from {trainings_text(combination.names, counts)}"
    questions = f"{asked} question{'s' * (asked != 1)} about the {combination.group.subject}, asked together; {least}."
    hints = f"{combination.claims} hint{'s' * (combination.claims != 1)}, corrected by themselves, decide nothing."
    return f"{questions} {hints}"


def ratio_grid(splits: Splits) -> Grid:
    """eta_N and eta_P with their intervals, and beside them what single seeds and the baseline's own runs give."""
    rows: list[tuple[str, ...]] = [
        (
            name,
            ratio_text(split.eta),
            interval_text(split.eta),
            ratio_text(split.per_seed),
            interval_text(split.noise),
            p_text(split.corrected),
            better_of(name),
        )
        for name, split in splits.items()
    ]
    headings = ("", "ratio", "95% interval", "seed by seed", "noise", "p", "better")
    notes = _lines(_remarks((name, split.eta) for name, split in splits.items()))
    known = {note for split in splits.values() for note in split.eta.notes}
    for part in ("per_seed", "noise"):
        told = ((f"{name} {LABELS[part]}", getattr(split, part)) for name, split in splits.items())
        notes += _lines((name, remark) for name, remark in _remarks(told) if remark not in known)
    flags = [f"{name}: {flag}" for name, split in splits.items() for flag in split.flags]
    return Grid(headings, rows, [*notes, *flags], "eta = proposed / baseline")


LABELS = {"per_seed": "seed by seed", "noise": "noise"}


def split_grid(splits: Splits) -> Grid:
    """Both etas as ruler x behaviour. Remarks on the etas themselves are not repeated."""
    headings = (*PARTS, "interaction")
    if not all(split.is_scored for split in splits.values()):
        reasons = dict.fromkeys(split.ruler.note for split in splits.values() if split.ruler != split.eta)
        return Grid(headings, [], [f"Not split into ruler x behaviour: {reason}" for reason in reasons])
    parts = {name: SplitPath(split.ruler, split.behaviour) for name, split in splits.items()}
    rows: list[tuple[str, ...]] = [
        (name, *_cells(part), ratio_text(splits[name].interaction)) for name, part in parts.items()
    ]
    return Grid(headings, rows, _part_notes(parts, _known(splits.values())), "eta = ruler x behaviour")


def path_grid(splits: Splits) -> Grid:
    """Both paths whose mean each split is. Remarks on the split itself are not repeated."""
    parts = {
        f"{name} on {where}": path
        for name, split in splits.items()
        for where, path in zip(PATH_NAMES, split.paths, strict=False)
    }
    known = _known(splits.values()) | {
        remark for split in splits.values() for part in (split.ruler, split.behaviour) for remark in part.remarks
    }
    rows: list[tuple[str, ...]] = [(name, *_cells(path)) for name, path in parts.items()]
    return Grid(PARTS, rows, _part_notes(parts, known), "ruler x behaviour, on each path")


PARTS = ("", "ruler", "95% interval", "behaviour", "95% interval")
PATH_NAMES = ("proposed runs", "baseline's runs")
"""Names of the paths: the runs on which a path's ruler is measured."""


def sum_grid(total: SumSplit | None) -> Grid:
    """The change of I_N + I_P and its parts; no rows if there is none."""
    headings = ("", "difference", "95% interval")
    if total is None:
        return Grid(headings, [], [])
    parts = {"change": total.change, "  of it ruler": total.ruler, "  of it behaviour": total.behaviour}
    rows: list[tuple[str, ...]] = [
        (name, format_number(part.mean), mean_interval_text(part))
        for name, part in parts.items()
        if part.mean is not None
    ]
    reasons = dict.fromkeys(part.note for part in parts.values() if part.note)
    return Grid(headings, rows, list(reasons), "I_N + I_P, proposed - baseline")


def index_grid(decomposition: Decomposition | None, kind: Kind = "accumulated") -> Grid:
    """The indices of both mean curves of that kind; no rows if there are none."""
    headings = (f"{kind} reward", "baseline", "proposed")
    if decomposition is None:
        return Grid(headings, [], [])
    names = ("first negative step", "cross-over step", "steps of the mean curve", "I_N", "I_P", "I_N + I_P")
    columns = _texts(decomposition.baseline), _texts(decomposition.proposed)
    return Grid(headings, list(zip(names, *columns, strict=True)), [])


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


def better_of(name: str) -> str:
    """Which side of 1 is called better for the ratio of that name: the ratio of I_N, of I_P, or of a mean return."""
    return BETTER.get(name, "above 1")


def ratio_text(ratio: Ratio) -> str:
    """The ratio, unless it says little because an index is near zero beside the other."""
    return format_number(ratio.value) if ratio.near_zero is None else NEAR_ZERO


def interval_text(ratio: Ratio, missing: str = NOTHING) -> str:
    """The ratio's interval, under the same condition; `missing` if there is none."""
    if ratio.near_zero is not None or ratio.low is None or ratio.high is None:
        return missing
    return f"[{format_number(ratio.low)}, {format_number(ratio.high)}]"


def ratio_with_interval(ratio: Ratio) -> str:
    """The ratio, and its interval if there is one to show."""
    return f"{ratio_text(ratio)} {interval_text(ratio, missing='')}".rstrip()


def format_number(value: float | None) -> str:
    """Three significant digits, without an exponent where that is readable."""
    if value is None:
        return NOTHING
    rounded = float(f"{value:.2e}") + 0.0  # no -0.0: an interval may end there
    size = math.floor(math.log10(abs(rounded))) if rounded else 0
    if not -4 <= size < 6:
        return f"{rounded:.2e}"
    return f"{rounded:,.{max(0, 2 - size)}f}"


def mean_interval_text(mean: SeedMean) -> str:
    """The interval of a mean."""
    if mean.low is None or mean.high is None:
        return NOTHING
    return f"[{format_number(mean.low)}, {format_number(mean.high)}]"


def _known(splits: Iterable[Split]) -> set[str]:
    """The remarks on the etas themselves."""
    return {remark for split in splits for remark in split.eta.remarks}


def _part_notes(parts: Mapping[str, SplitPath], known: Collection[str]) -> list[str]:
    """Remarks on rulers and behaviours, by what they are parts of."""
    named = ((f"{what} of {name}", part) for name, path in parts.items() for what, part in path._asdict().items())
    return _lines(_remarks(named, known))


def _cells(path: SplitPath) -> tuple[str, ...]:
    return tuple(text for ratio in path for text in (ratio_text(ratio), interval_text(ratio)))


def _remarks(ratios: Iterable[tuple[str, Ratio]], known: Collection[str] = ()) -> Iterator[tuple[str, str]]:
    """For each ratio: its name, with n/a if it has no value, and a remark.

    A remark that is `known` already is left out, unless it says why there is no value.
    """
    for name, ratio in ratios:
        for remark in ratio.remarks:
            if ratio.value is None:
                yield f"{name} {NOTHING}", remark
            elif remark not in known:
                yield name, remark


def _lines(remarks: Iterable[tuple[str, str]]) -> list[str]:
    """One line for each remark, with all that it holds for."""
    subjects: dict[str, list[str]] = {}
    for name, remark in remarks:
        subjects.setdefault(remark, []).append(name)
    return [f"{', '.join(names)}: {remark}" for remark, names in subjects.items()]


def _texts(index: Index) -> Iterator[str]:
    for step in (index.first_negative, index.crossover):
        yield "never" if step is None else f"{step:,}"
    yield f"{index.steps:,}"
    for total in (index.I_N, index.I_P, index.total):
        yield f"{total:,.1f}"


def question(results: Results) -> str:
    """What the report answers."""
    if results.alone and not results.combinations:
        return f"What did {' and '.join(dict.fromkeys(it.reward for it in results.alone))} pay for?"
    labels = dict.fromkeys(combination.proposed for combination in results.combinations)
    proposed = [label for label in labels if label != results.baseline]  # that would be A/A
    if results.plan.terms.race:
        names = [results.baseline, *proposed]
        return f"Which reward makes the {results.subject} behave best: {', '.join(names[:-1])} or {names[-1]}?"
    verb, subject = ("Does", "a reward") if not proposed else ("Does", f"the reward {proposed[0]}")
    if len(proposed) > 1:
        verb, subject = "Do", f"the rewards {', '.join(proposed[:-1])} and {proposed[-1]}"
    return f"{verb} {subject} make the {results.subject} behave better, or only the numbers bigger?"
