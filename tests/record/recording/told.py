"""Columns of a recorded training by the names of its terms and measures."""


def terms_of(log, reward):
    """What each term of a reward paid, (steps,) each, in their order."""
    return {name: log[f"reward/{reward}/{name}"] for name in log.terms_of(reward)}
