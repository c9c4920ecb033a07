"""Everything that a report says, as plain data."""

import json
from collections.abc import Sequence
from typing import Any

from harness.results import Results
from harness.results.learning import learning_of
from harness.results.ranking import ranking_of
from harness.results.return_matrix import ReturnMatrix, return_matrices
from harness.transfer.matrix import load_transfers


def report_to_json(results: Results, matrices: Sequence[ReturnMatrix] | None = None) -> dict[str, Any]:
    """The whole report as plain data. ``harness report --json`` prints it by `report_text`.

    Args:
        results: The results to report.
        matrices: The returns under every reward, if they are known already.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    data = results.to_json()
    for told, combination in zip(data["combinations"], results.combinations, strict=True):
        learning = learning_of(results, combination)
        told["learning"] = learning and learning.to_json()
    known = return_matrices(results) if matrices is None else matrices
    data["evaluation_returns"] = [matrix.to_json() for matrix in known]
    data["ranking"] = ranking_of(results).to_json()
    transfers = load_transfers(results)
    return {**data, "transfer": transfers.to_json()} if transfers.matrices else data


def report_text(results: Results, matrices: Sequence[ReturnMatrix] | None = None) -> str:
    """What ``harness report --json`` prints, and what ``results.json`` of a summary holds."""
    return json.dumps(report_to_json(results, matrices), indent=1, allow_nan=False)
