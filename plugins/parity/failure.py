"""What an engine raised, kept: one that fails costs itself alone."""

from collections.abc import Callable, Mapping
from typing import NamedTuple, TypeVar

from harness.errors import HarnessError, one_line

Result = TypeVar("Result")


class Failure(NamedTuple):
    """Why there is no result; one line."""

    reason: str


def attempt(work: Callable[[], Result]) -> Result | Failure:
    """The result of `work`, or why there is none, whatever a stranger's engine raises."""
    try:
        return work()
    except Exception as error:
        told = " ".join(str(error).split()) if isinstance(error, HarnessError) else ""
        return Failure(told or one_line(error))


def part(outcomes: Mapping[str, Result | Failure]) -> tuple[dict[str, Result], dict[str, Failure]]:
    """The results and the failures, in their order."""
    results: dict[str, Result] = {}
    failures: dict[str, Failure] = {}
    for name, outcome in outcomes.items():
        if isinstance(outcome, Failure):
            failures[name] = outcome
        else:
            results[name] = outcome
    return results, failures
