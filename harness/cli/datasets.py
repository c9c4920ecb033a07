"""Data sets, given to a command in the place of a folder."""

from collections.abc import Sequence
from pathlib import Path

from harness.cli.output import complain, say, say_json


def names_dataset(target: str | Path) -> bool:
    """Whether a command got a data set: ``minari:NAME``, ``d4rl:FILE`` and the like, or an HDF5 file."""
    from harness.record.dataset.open_dataset import is_dataset

    def formats() -> list[str]:
        from harness.registry.registry import load_registry

        return list(load_registry().names("logs"))

    return is_dataset(str(target), formats)


def score_dataset(
    dataset: str,
    rewards: Sequence[str],
    plugin: Sequence[str] | None,
    places: str | None,
    robot: str | None,
    out: Path | None,
    partial: bool,
    as_json: bool,
) -> int:
    """Write what rewards pay each step of a data set; status 1 where one could not pay."""
    import numpy as np

    from harness.payoff.dataset.arm_pay import places_of
    from harness.payoff.dataset.paid_dataset import pay_dataset
    from harness.payoff.dataset.rewards import rewards_of
    from harness.payoff.dataset.scores_file import scores_place, write_dataset_scores
    from harness.record.dataset.open_dataset import open_dataset
    from harness.registry.given import read_given
    from harness.registry.registry import load_registry

    registry = load_registry(given=read_given(plugin))
    arm, opened = places_of(places, robot, registry), open_dataset(dataset, registry, partial=partial)
    paid = pay_dataset(opened, rewards_of(opened, registry, rewards, arm), arm)
    into, terms = scores_place(opened.facts.path, out), paid.terms
    write_dataset_scores(paid, into)
    if as_json:
        told = {"file": dataset, "scores": str(into), "rewards": list(paid.paid)}
        say_json({"files": [{**told, **({"terms": {name: [*of] for name, of in terms.items()}} if terms else {})}]})
    else:
        say(f"{dataset} -> {into}")
        for name, of in terms.items():
            means = ", ".join(f"{term} {np.nanmean(values):.4g}" for term, values in of.items())
            say(f"{name} pays a step on average {np.nanmean(paid.paid[name]):.4g}: {means}")
    for line in (*opened.facts.notes, *paid.notes):
        complain(line)
    for name, reason in paid.failed.items():
        complain(f"reward {name}: n/a ({reason})")
    return 1 if paid.failed else 0
