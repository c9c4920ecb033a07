"""What is said of metrics that failed."""

from typing import TYPE_CHECKING

from harness.cli.lines import complain

if TYPE_CHECKING:
    from harness.results import Results


def complain_of_metrics(results: "Results") -> None:
    """One line on standard error for each metric that failed: its values are missing, and nothing else."""
    for name, reason in results.not_measured.items():
        complain(f"metric {name}: n/a ({reason})")
