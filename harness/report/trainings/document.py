"""Everything that a study of recorded trainings says, as JSON."""

import json
from typing import Any

from harness.results.recordings.learning import learning_of
from harness.results.recordings.study import Study


def study_json(study: Study) -> str:
    """What ``harness report FOLDER --json`` and ``harness eta FOLDER --json`` print."""
    return json.dumps(study_to_json(study), indent=1, allow_nan=False)


def study_to_json(study: Study) -> dict[str, Any]:
    """The same, as plain data."""
    data = study.to_json()
    for told, comparison in zip(data["comparisons"], study.comparisons, strict=True):
        learning = learning_of(study.runs, comparison)
        told["learning"] = learning and learning.to_json()["metrics"]
    return data
