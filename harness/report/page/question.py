"""The question that an experiment asks."""

from harness.results import Results


def question(results: Results) -> str:
    """What the report answers."""
    labels = dict.fromkeys(combination.proposed for combination in results.combinations)
    proposed = [label for label in labels if label != results.baseline]  # that would be A/A
    verb, subject = ("Does", "a reward") if not proposed else ("Does", f"the reward {proposed[0]}")
    if len(proposed) > 1:
        verb, subject = "Do", f"the rewards {', '.join(proposed[:-1])} and {proposed[-1]}"
    return f"{verb} {subject} make the {results.subject} behave better, or only the numbers bigger?"
