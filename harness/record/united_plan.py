"""One plan of several experiments' folders."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from harness.errors import UsageError
from harness.record.cell import Cell
from harness.record.plan_file import StoredPlan
from harness.record.terms import FIRST, Terms

LISTS = ("sim", "algo", "reward")
"""Keys of an experiment that hold names; each multiplies the cells, as ``seeds`` does."""


def unite(plans: Sequence[tuple[Path, StoredPlan]]) -> StoredPlan:
    """The plan of all cells.

    Where the experiments differ in one of their lists alone, the experiment is the one that asks for all of it, and the
    cells come in its order. Else it is the last one, as in a folder where one experiment was run after the other.

    Args:
        plans: Each with the folder that it stands in.

    Raises:
        UsageError: They have several baselines, or some are in an environment and others are not.
    """
    (first, whole), *others = plans
    for folder, plan in others:
        if plan.baseline != whole.baseline:
            raise UsageError(
                f"'{first}' compares with {whole.baseline}, '{folder}' with {plan.baseline}: "
                "only experiments with one baseline can be merged"
            )
        refuse_mixed(f"'{first}' and '{folder}'", whole.cells, plan.cells)
        whole = _unite(whole, plan)
    return whole


def refuse_mixed(where: str, cells: Iterable[Cell], others: Iterable[Cell]) -> None:
    """See that all cells are made of the same kinds of plugins: an environment has none of what an arm has.

    Raises:
        UsageError: It is not so.
    """
    if len({tuple(cell.plugins) for cell in (*cells, *others)}) > 1:
        raise UsageError(
            f"{where}: an experiment in an environment and one with a robot of the harness do not go into one folder. "
            "Name another"
        )


def _unite(one: StoredPlan, other: StoredPlan) -> StoredPlan:
    control = {**one.control, **other.control}
    both = replace(
        other, control=control, a_a=one.a_a or other.a_a, terms=_terms_of_both(one.terms, other.terms)
    ).with_cells_of(one.cells)
    experiment = _experiment_of_both(one, other)
    return replace(both, cells=_in_order(both), experiment=experiment) if experiment else both


def _terms_of_both(one: Terms, other: Terms) -> Terms:
    """What both agreed on; `FIRST` where that is not the same. What was added later to either stays told."""
    agreed = one if _agreed(one) == _agreed(other) else FIRST
    grown = tuple(sorted({*one.grown, *other.grown}))
    return replace(agreed, grown=grown, joined=tuple(dict.fromkeys((*one.joined, *other.joined))))


def _agreed(terms: Terms) -> Terms:
    """The terms without what was added later."""
    return replace(terms, grown=(), joined=())


def _experiment_of_both(one: StoredPlan, other: StoredPlan) -> dict[str, Any]:
    """The experiment that asks for the cells of both; empty where no single one does."""
    first, second = _with_seed_list(one), _with_seed_list(other)
    differing = [key for key in {**first, **second} if first.get(key) != second.get(key)]
    if not differing:
        return first
    key, *more = differing
    if more or key not in (*LISTS, "seeds") or not all(isinstance(it.get(key), list) for it in (first, second)):
        return {}
    items = [*first[key], *(item for item in second[key] if item not in first[key])]
    is_sorted = all(isinstance(item, int) for item in items)
    return {**second, key: sorted(items) if is_sorted else items}


def _with_seed_list(plan: StoredPlan) -> dict[str, Any]:
    """The experiment with its seeds one by one; a number of seeds that the cells do not have stays a number."""
    seeds = plan.experiment.get("seeds")
    if not isinstance(seeds, int) or seeds > len(plan.cells):
        return dict(plan.experiment)
    return {**plan.experiment, "seeds": list(range(seeds))}


def _in_order(plan: StoredPlan) -> tuple[Cell, ...]:
    """Cells in the order in which one experiment has them: seeds outermost, the null control's last."""
    ranks: Mapping[Any, int] = {
        choice: rank
        for rank, choice in enumerate(
            dict.fromkeys(choice for cell in plan.cells for choice in (cell.place, cell.algorithm, cell.reward))
        )
    }
    others = set(plan.control.values()) - set(plan.control)

    def place(cell: Cell) -> tuple[bool, int, int, int, int]:
        is_control = cell.seed in others and cell.reward.label == plan.baseline
        return (is_control, cell.seed, ranks[cell.place], ranks[cell.algorithm], ranks[cell.reward])

    return tuple(sorted(plan.cells, key=place))
