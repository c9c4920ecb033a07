"""Everything that a report says, as plain data."""

import json
from typing import Any

from harness.report.rows.choosing import choosing_told
from harness.results import Results
from harness.results.ranking import ranking_of
from harness.results.standing import standing_of, standing_to_json, told_manifests
from harness.section import shown_sections


def report_to_json(results: Results) -> dict[str, Any]:
    """The whole report as plain data. ``harness report --json`` prints it by `report_text`.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    data = results.to_json()
    for told, comparison in zip(data["combinations"], results.combinations, strict=True):
        learning = results.learning(comparison)
        told["learning"] = learning and learning.to_json()
    data["evaluation_returns"] = [matrix.to_json() for matrix in results.returns]
    data["ranking"] = ranking_of(results).to_json()
    data["notes"] = [*results.said, *results.notes]
    for told, manifest in zip(data["cells"], told_manifests(results), strict=True):
        told |= {"status": manifest.status, "reason": manifest.reason}
    data |= standing_to_json(standing_of(results))
    if chosen := choosing_told(results):
        data["choosing"]["told"] = chosen.sentence
    data |= {name: section.to_json() for name, section in shown_sections(results).items()}
    data |= {"reward_terms": [it.to_json() for it in results.terms]} if results.terms else {}
    data |= {"alone": [it.to_json() for it in results.alone]} if results.alone else {}
    return data


def report_text(results: Results) -> str:
    """What ``harness report --json`` prints, and what ``results.json`` of a summary holds."""
    return json.dumps(report_to_json(results), indent=1, allow_nan=False)
