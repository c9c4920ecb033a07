"""Rankings as text: sentences and small tables that the terminal and the page share."""

from collections.abc import Iterable, Mapping, Sequence

from harness.eta.headline import estimate_text, interval_text, points, value_text
from harness.eta.index import NOTHING, Estimate
from harness.eta.ranking import Answer
from harness.report.rows import Fact, Grid
from harness.results.overview import ARROW
from harness.results.ranking import ROUNDING, Kind, PlacePair, TaskRanking

TITLE = "Would you have chosen another reward elsewhere?"
EXPLANATION = (
    "A place is where policies were trained, with one algorithm. Two places are compared if only one of these two "
    "differs. Success is the share of evaluation episodes that succeed: the truth here. eta_P is the note's "
    "number. Its behaviour is what is left of it without rescaling. Each cell has the rank, then the value."
)
CHOICE = (
    "The best reward of the first place is used in the second, and compared with the reward that is best there. YES: "
    "no reward that may be the best one in the first place may be the best one in the second. NO: the choice costs "
    "less than 5 points of success there. Otherwise the seeds do not decide it. If rewards do not differ, at most 5% "
    "of experiments say YES anywhere: all intervals of a task hold together, also for a choice made from the same data."
)
AGREEMENT = (
    "tau is Kendall's tau-b of two orders by success. 1 is the same order, 0 an unrelated one, -1 the opposite one. "
    "The 95% interval spans every order that the seeds leave open. With few seeds that is every order."
)
SCORES = ("eta_P", "eta_N")
"""Each has a table of ranks, by itself and by its behaviour."""
CHOICES = ("chosen in -> used in", "choice", "best there", "costs there\n[points]", "another\nreward?", "what is open")
AGREEMENTS = ("order by success", "tau", "95% interval", "")


def ranking_facts(tasks: Iterable[TaskRanking]) -> list[Fact]:
    """The question, of each task the answer and what it rests on, and how to read that."""
    facts = []
    for task in tasks:
        title = " · ".join(filter(None, (task.task, task.robot, f"{task.steps:,} steps")))
        grids = (*(_ranks_grid(task, name) for name in SCORES), _choices(task), _agreements(task))
        facts.append(Fact(title, tuple(_lines_of(task)), grids))
    reading = Fact(lines=(f"{EXPLANATION} {CHOICE} {AGREEMENT}",), kind="reading")
    return [Fact(TITLE), *facts, reading]


def _lines_of(task: TaskRanking) -> list[str]:
    """The answer in sentences: choices, then orders."""
    counts = {answer: task.count(answer) for answer in Answer}
    told = ", ".join(f"{answer.value} {count}" for answer, count in counts.items())
    costly = sum(it.is_costly for it in task.transplants)
    certain = f" In {costly} of them the choice costs success for certain." if costly else ""
    lines = [f"Another reward chosen in another place? {told}; {sum(counts.values())} choices in all.{certain}"]
    for kind, agreement in task.between.items():
        lines.append(f"Order of the rewards across {_votes_text(task, kind)}: {agreement_text(agreement)}.")
    if "simulator" in task.between and not task.has_engines:
        lines.append("Some cells do not record their engine: each of their simulators counts as an engine of its own.")
    if task.left_out:
        lines.append(f"Not in every place, and left out: {', '.join(task.left_out)}.")
    return lines


def agreement_text(agreement: Estimate) -> str:
    """Tau with its interval, or why there is none."""
    if agreement.value is None:
        return f"tau {NOTHING}, {agreement.note}"
    note = agreement.note and f" ({agreement.note})"
    return f"tau {estimate_text(agreement, tau_text)}{note}"


def tau_text(tau: float | None) -> str:
    """Kendall's tau as text."""
    return NOTHING if tau is None else f"{tau:.2f}"


def _votes_text(task: TaskRanking, kind: Kind) -> str:
    votes = task.votes(kind)
    place = "engine" if task.robot else "environment"
    noun = place if kind == "simulator" else "algorithm"
    return f"{len(votes)} {noun}{'s' * (len(votes) != 1)} ({', '.join(votes)})"


def _ranks_grid(task: TaskRanking, score: str) -> Grid:
    """The rank of every reward in every place: by success, by an eta, by its behaviour part.

    In the last row stands Kendall's tau between each column's order and that of success.
    """
    headings, columns, taus = ["reward"], list[Mapping[str, str]](), ["tau with success"]
    for name, place in zip(_place_names(task), task.places, strict=True):
        order, eta, behaviour = place.success, place.etas[score], place.etas[f"{score} behaviour"]
        by_success = sorted(zip(order.rewards, order.means.tolist(), strict=True), key=lambda item: -item[1])
        headings += (f"{name}\n{measure}" for measure in ("success", score, f"{score} behaviour"))
        columns.append(_ranks([(reward, f"{100 * mean:.0f}%", mean) for reward, mean in by_success]))
        columns += (_ranks([(it, f"{value:.3g}", value) for it, value in by.values.items()]) for by in (eta, behaviour))
        taus += ("", tau_text(eta.tau), tau_text(behaviour.tau))
    rows = [(reward, *(column.get(reward, NOTHING) for column in columns)) for reward in task.rewards]
    return Grid(tuple(headings), [*rows, tuple(taus)], [])


def _ranks(ordered: Sequence[tuple[str, str, float]]) -> dict[str, str]:
    """Rank and value of rewards, best first. Equal values share the better rank."""
    found: dict[str, str] = {}
    place, last = 0, None
    for number, (reward, text, value) in enumerate(ordered, start=1):
        if last is None or abs(value - last) > ROUNDING:
            place, last = number, value
        found[reward] = f"{place}. {text}"
    return found


def _place_names(task: TaskRanking) -> list[str]:
    """The names of a task's places: what tells them apart."""
    simulators, algorithms = ({getattr(it, kind) for it in task.places} for kind in ("simulator", "algorithm"))
    return [
        " · ".join([*([it.simulator] if len(simulators) > 1 else []), *([it.algorithm] if len(algorithms) > 1 else [])])
        for it in task.places
    ]


def _choices(task: TaskRanking) -> Grid:
    rows: list[tuple[str, ...]] = []
    for pair in task.pairs:
        for (here, there), found in zip((pair.names, pair.names[::-1]), (pair.forth, pair.back), strict=True):
            shared = _shared(task, pair)
            told = estimate_text(found.cost, points), found.answer.value.upper(), found.cost.note
            rows.append((f"{here}{ARROW}{there}{shared}", found.chosen, found.best, *told))
    return Grid(CHOICES, rows, [])


def _agreements(task: TaskRanking) -> Grid:
    rows: list[tuple[str, ...]] = []
    for pair in task.pairs:
        agreement = pair.agreement
        same = [f"one engine ({pair.votes[0]}): no second vote"] if pair.votes[0] == pair.votes[1] else []
        name, told = f"{' / '.join(pair.names)}{_shared(task, pair)}", "; ".join([*agreement.remarks, *same])
        rows.append((name, value_text(agreement, tau_text), interval_text(agreement, text=tau_text), told))
    return Grid(AGREEMENTS, rows, [])


def _shared(task: TaskRanking, pair: PlacePair) -> str:
    """What both places have in common and other places have not."""
    other = "algorithm" if pair.kind == "simulator" else "simulator"
    return f" ({pair.shared})" if len({getattr(it, other) for it in task.places}) > 1 else ""
