"""Every number of a comparison: mean returns and both indices, and what they split into."""

from harness.eta.curve import Kind
from harness.eta.splits import Splits
from harness.report.rows.ratios import Grid, index_grid, split_grids, sum_grid
from harness.report.rows.returns import PAY, returns_grid
from harness.results.comparison import Comparison

INDICES = "The note's eta_N and eta_P"


def splits_of(comparison: Comparison) -> Splits:
    """The eta of the mean return in the manner that decides, then those of both indices, as far as they are split."""
    main = {} if comparison.number.main is None else {"eta": comparison.number.main.ratio}
    return {**main, **(comparison.number.index_splits if comparison.number.is_split else {})}


def number_grids(comparison: Comparison, kind: Kind, with_paths: bool = False) -> list[Grid]:
    """The grids that have something to show, in the order in which they are read.

    Args:
        comparison: The comparison.
        kind: Of the curves that the indices are read from.
        with_paths: Whether both paths of every split are shown too.
    """
    number, grids = comparison.number, [returns_grid(comparison)]
    returned = {f"pay, {manner}": split.ratio for manner, split in number.returns.items()}
    indices = number.index_splits or number.splits if number.has_pay else {}
    for name, found in ((PAY, returned), (INDICES, indices)):
        of_name = split_grids(found, with_paths) if found else []
        grids += [grid._replace(title=f"{name}: {grid.title}") for grid in of_name]
    if number.decomposition is not None:
        grids += [sum_grid(number.decomposition.total), index_grid(number.decomposition, kind)]
    return [grid for grid in grids if grid.rows or grid.notes]
