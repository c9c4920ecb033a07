"""Everything that a report says about an experiment whose task is an environment, as JSON."""

import json
from typing import Any

from harness.report.trainings.document import study_to_json
from harness.results import Results
from harness.results.recordings.places import PlaceStudy
from harness.results.table import cell_to_json


def environments_text(results: Results) -> str:
    """What ``harness report --json`` prints, and what ``results.json`` of a summary holds."""
    data = {
        "baseline": results.baseline,
        "curve": results.kind,
        "studies": [_to_json(told) for told in results.studies],
        "cells": [{**cell_to_json(it), "task": it.cell.task.label} for it in results.manifests],
    }
    return json.dumps(data, indent=1, allow_nan=False)


def _to_json(told: PlaceStudy) -> dict[str, Any]:
    labels = {"task": told.group.task.label, "algorithm": told.group.algorithm.label}
    study = told.study and study_to_json(told.study)
    return {**labels, "steps": told.group.steps, "reason": told.reason, "notes": list(told.notes), "study": study}
