"""The answers over all places, as the terminal, the page and the summary show them."""

from collections.abc import Sequence

from harness.eta.amounts import listed
from harness.eta.headline import count_seeds
from harness.report.answers import word_of
from harness.results import Results
from harness.results.choosing import Choosing
from harness.results.comparison import Comparison, pools_of
from harness.results.standing import standing_of

POOLED_TITLE = "Over all places"
POOLED = (
    "A place is a simulator, a task and an algorithm with which both rewards trained. The first answer is about the "
    "mean over all places. Single places are asked only where that answer stands."
)
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
