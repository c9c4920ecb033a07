"""Everything that a study of recorded trainings says, as JSON."""

import json

from harness.trainings.learning import learning_of
from harness.trainings.study import Study


def study_json(study: Study) -> str:
    """What ``harness report FOLDER --json`` and ``harness eta FOLDER --json`` print."""
    data = study.to_json()
    for told, comparison in zip(data["comparisons"], study.comparisons, strict=True):
        learning = learning_of(study.runs, comparison)
        told["learning"] = learning and learning.to_json()["metrics"]
    return json.dumps(data, indent=1, allow_nan=False)
