"""What is told of checks, on its way from another process."""

import json

from harness_plugins.kit.inspection.finding import Finding, Outline, PlannedCheck, count


def test_outline_survives_the_way_through_json():
    """With its findings, and the checks that are to be run."""
    planned = PlannedCheck("reward-finite", "Rewards are finite.", 30.0, long=False)
    outline = Outline("rewards", (Finding("target", "ok"),), (planned,), "a mistake")
    assert Outline.from_json(json.loads(json.dumps(outline.to_json()))) == outline


def test_findings_are_counted_by_verdict():
    """Those of other verdicts are not."""
    findings = [Finding("one", "ok"), Finding("two", "error"), Finding("three", "ok")]
    assert [count(findings, verdict) for verdict in ("ok", "error", "warning")] == [2, 1, 0]
