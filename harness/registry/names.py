"""What to say of a name that is not there."""

import difflib
from collections.abc import Iterable


def unknown_name(noun: str, name: str, known: Iterable[str]) -> str:
    """One line: what was given, what there is, the nearest match."""
    known = sorted(known)
    return f"No {noun} '{name}'. There is: {', '.join(known) or 'none'}.{did_you_mean(name, known)}"


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """A question to add to a message; empty without a near match."""
    nearest = difflib.get_close_matches(name, list(known), n=1)
    return f" Did you mean '{nearest[0]}'?" if nearest else ""
