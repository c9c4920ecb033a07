"""Everything that a study of recorded trainings says, as JSON."""

import json
from typing import Any

from harness.results.recordings.learning import learning_of
from harness.results.recordings.study import Study
from harness.results.results import FORMAT


def study_json(study: Study) -> str:
    """What ``harness report FOLDER --json`` and ``harness eta FOLDER --json`` print."""
    head = {"format": FORMAT, "baseline": study.runs.trained[0], "curve": study.kind}
    data = {**head, "combinations": combinations_to_json(study), **study_to_json(study)}
    return json.dumps(data, indent=1, allow_nan=False)


def combinations_to_json(study: Study) -> list[dict[str, Any]]:
    """Its comparisons, as `harness.report.document` tells those of arms."""
    found = []
    for comparison in study.comparisons:
        learning = learning_of(study.runs, comparison)
        found.append({**comparison.to_json(), "learning": learning and learning.to_json()})
    return found


def study_to_json(study: Study) -> dict[str, Any]:
    """Its keys of version 0.1, which leave with the next format."""
    data = study.to_json()
    for told, comparison in zip(data["comparisons"], study.comparisons, strict=True):
        learning = learning_of(study.runs, comparison)
        told["learning"] = learning and learning.to_json()["metrics"]
    return data
