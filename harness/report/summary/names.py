"""File names of a combination's figures."""

import hashlib
import re
from collections import Counter
from collections.abc import Sequence

from harness.results.combination import Combination

LONGEST = 120
"""Characters; a longer name is cut, and ends in a hash of the whole."""


def figure_stems(combinations: Sequence[Combination]) -> list[str]:
    """A name for each combination, of lower-case letters, digits, dots and hyphens; no two are alike."""
    counts: Counter[str] = Counter()
    stems = []
    for combination in combinations:
        stem = _stem(combination)
        counts[stem] += 1
        stems.append(stem if counts[stem] == 1 else f"{stem}-{counts[stem]}")
    return stems


def _stem(combination: Combination) -> str:
    labels = {**combination.group.labels, "robot": combination.group.robot.rsplit("/")[-1]}
    text = " ".join([*labels.values(), combination.proposed, "against", combination.baseline])
    stem = re.sub(r"[^a-z0-9.]+", "-", text.lower()).strip("-.")
    if len(stem) <= LONGEST:
        return stem
    digest = hashlib.sha256(text.encode()).hexdigest()[:8]
    return f"{stem[: LONGEST - 9]}-{digest}"
