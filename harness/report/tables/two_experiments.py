"""What changed between two experiments, as a terminal shows it."""

from rich.console import Group, RenderableType
from rich.text import Text

from harness.eta.behaviour_change import Change
from harness.eta.headline import SHORT, Answer, count_seeds
from harness.report.answers import LOOKS
from harness.report.rows.behaviour import behaviour_row
from harness.report.rows.comparison import answer_text
from harness.report.rows.ratios import Grid
from harness.report.tables.grid import show_grid
from harness.results.comparison import Comparison
from harness.results.overview import ARROW, line_names, measure_text, pay_texts, shared_text
from harness.results.two_experiments import BeforeAfter, Between, Verdict

STYLES = {
    Verdict.BETTER.value.upper(): LOOKS[Answer.HELPS].style,
    Verdict.WORSE.value.upper(): LOOKS[Answer.HURTS].style,
}
READING = (
    "Values are before -> after. the policy: do the proposed reward's policies do better or worse than before? A test "
    "over the seeds that are in both says so. {subject}: does the proposed reward help, compared with the baseline? "
    "pay: what an episode is paid under the proposed reward, compared with the baseline's."
)

NOTHING_MOVED = "No measure moved by more than chance allows, all of them tested together."
INTERIM = (
    "Interim: planned trainings of an experiment are still to come. Nothing here says yet what is better or worse."
)


def between_table(found: Between) -> RenderableType:
    """A line per combination, then the measures that moved, then what is in one of the experiments alone."""
    combinations = [pair.before for pair in found.pairs]
    names = line_names(combinations)
    rows = [_row(name, pair) for name, pair in zip(names, found.pairs, strict=True)]
    parts: list[RenderableType] = [Text(shared_text(combinations, with_seeds=False), style="bold")]
    subject = f"the {combinations[0].group.subject}"
    decides = " / ".join(dict.fromkeys(_measure_text(it) for it in combinations))
    headings = ("", "the policy", decides, "seeds", subject, "pay")
    reading = Text(READING.format(subject=subject), style="dim")
    parts += [*show_grid(Grid(headings, rows, []), STYLES), Text(), reading, Text()]
    moved = [_moved(name, change) for name, pair in zip(names, found.pairs, strict=True) for change in pair.moved]
    parts += map(Text, moved or [INTERIM if any(pair.is_interim for pair in found.pairs) else NOTHING_MOVED])
    parts += map(Text, dict.fromkeys(line for pair in found.pairs for line in _notes(pair)))
    for where, alone in (("first", found.only_before), ("second", found.only_after)):
        parts += [Text(f"only in the {where}: {it.group.title} · {it.proposed}") for it in alone]
    return Group(*parts)


def _row(name: str, pair: BeforeAfter) -> tuple[str, ...]:
    answers = [answer_text(it.headline) for it in (pair.before, pair.after)]
    pays = [pay_texts(it.number.pay)[1] for it in (pair.before, pair.after)]
    seeds = str(pair.decisive.seeds) if pair.decisive else "0"
    return (name, pair.verdict.value.upper(), _decisive(pair), seeds, _change(answers), _change(pays))


def _measure_text(comparison: Comparison) -> str:
    """The measure that decides, for a heading."""
    return next((SHORT.get(name, name.replace("_", " ")) for name in comparison.measured.deciding), "behaviour")


def _decisive(pair: BeforeAfter) -> str:
    """Both values of the measure that decides."""
    return measure_text(pair.decisive)


def _notes(pair: BeforeAfter) -> list[str]:
    """What to keep in mind of the measures."""
    missing = [f"{it.name} is not compared: {it.reason}." for it in pair.changes if it.reason and not it.seeds]
    other = [
        f"The code of {name} is not the same in both: its numbers may not be comparable." for name in pair.other_code
    ]
    return [*missing, *other]


def _change(texts: list[str]) -> str:
    """Both texts, or one if they are alike."""
    return ARROW.join(dict.fromkeys(texts))


def _moved(name: str, change: Change) -> str:
    row = behaviour_row(change)
    return (
        f"{name}: {row.name} is {change.direction}: {row.baseline}{ARROW}{row.proposed}, difference {row.difference}; "
        f"{count_seeds(change.seeds)}, corrected p {row.p}"
    )
