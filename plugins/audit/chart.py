"""A chart of a few curves, as the pages of audits draw them."""

from collections.abc import Sequence

import numpy as np

from harness.report import Chart, Dots, Line, linear_axis

LEAST = 1e-100
"""A smaller range is drawn as none."""


def chart_of(marks: Sequence[Line | Dots], across: str, upwards: str) -> Chart:
    """Marks from 0 on both axes, with some air above and below; numbers that are not known are left out."""
    last = max(max(mark.x) for mark in marks)
    told = np.concatenate([[0.0], *(mark.y for mark in marks)])
    low, high = float(np.nanmin(told)), float(np.nanmax(told))
    air = 0.04 * (high - low) if high - low > LEAST else 0.5
    return Chart(
        linear_axis(0.0, last if last > LEAST else 1.0, across, 5),
        linear_axis(low - air, high + air, upwards),
        tuple(marks),
    )
