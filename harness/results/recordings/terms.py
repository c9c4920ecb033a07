"""What each term of the rewards that taught recorded trainings paid; see `harness.results.terms_paid`."""

from collections.abc import Iterator

from harness.results.recordings.runs import Run, Runs
from harness.results.terms_paid import TermsPaid, Trained, terms_paid


def terms_of_runs(runs: Runs) -> Iterator[TermsPaid]:
    """What each term paid, of each reward that has terms. All rewards have paid all recordings already."""
    baseline = runs.trained[0]
    for reward in runs.trained:
        own = [_trained(run, reward) for run in runs.of(reward)]
        beside = runs.of(baseline) if reward != baseline else []
        others = [_trained(run, reward) for run in beside]
        ours = [_trained(run, baseline) for run in beside]
        random = runs.random.recorded.terms_paid(reward) if runs.random else None
        found = terms_paid(runs.group, (reward, baseline if beside else ""), own, others, ours, random)
        if found is not None:
            yield found


def _trained(run: Run, reward: str) -> Trained:
    evaluation = run.evaluation.recorded.terms_paid(reward) if run.evaluation else None
    return Trained(run.recorded.terms_paid(reward), evaluation)
