"""Everything that a report says about an experiment whose task is an environment, as JSON."""

import json
from typing import Any

from harness.report.trainings.document import combinations_to_json, study_to_json
from harness.results import Results
from harness.results.recordings.places import PlaceStudy


def environments_text(results: Results) -> str:
    """What ``harness report --json`` prints, and what ``results.json`` of a summary holds."""
    compared = [study for told in results.studies if (study := told.study) is not None]
    data = {
        **results.to_json(),
        "combinations": [told for study in compared for told in combinations_to_json(study)],
        "studies": [_to_json(told) for told in results.studies],
    }
    return json.dumps(data, indent=1, allow_nan=False)


def _to_json(told: PlaceStudy) -> dict[str, Any]:
    labels = {"task": told.group.task.label, "algorithm": told.group.algorithm.label}
    study = told.study and study_to_json(told.study)
    return {**labels, "steps": told.group.steps, "reason": told.reason, "notes": list(told.notes), "study": study}
