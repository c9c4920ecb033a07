"""File names of a combination's figures."""

from collections.abc import Iterable

from harness.authoring.commands import Comparison
from harness.text import file_stems


def figure_stems(combinations: Iterable[Comparison]) -> list[str]:
    """A name for each combination, of lower-case letters, digits, dots and hyphens; no two are alike."""
    return file_stems(map(_text, combinations))


def _text(combination: Comparison) -> str:
    labels = combination.group.labels
    labels |= {"robot": labels["robot"].rsplit("/")[-1]} if "robot" in labels else {}
    return " ".join([*labels.values(), combination.proposed, "against", combination.baseline])
