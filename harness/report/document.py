"""Everything that a report says, as plain data."""

import json
from collections import Counter
from collections.abc import Iterable
from dataclasses import asdict
from typing import Any, NamedTuple

from harness.record.cell import Manifest
from harness.report.facts import Report
from harness.report.rows.comparison import again_text
from harness.results import Results
from harness.results.results import standing_of, standing_to_json, told_manifests


class CellFact(NamedTuple):
    """A fact from the manifests, and in how many cells it holds if not in all."""

    name: str
    value: str
    cells: str


def shared_facts(manifests: Iterable[Manifest]) -> list[CellFact]:
    """Versions, machine, engine, commit, command, sources of all cells that ran; a line each, or more."""
    counts: dict[str, Counter[str]] = {}
    for manifest in manifests:
        for name, value in _facts(manifest).items():
            counts.setdefault(name, Counter())[value] += 1
    return [
        CellFact(name, value, f"{count} of {values.total()} cells" if len(values) > 1 else "")
        for name, values in counts.items()
        for value, count in values.items()
    ]


def repeat_of(results: Results) -> dict[str, Any]:
    """What a page says of how to repeat an experiment: the command, the experiment's text, what all cells share.

    Nothing where no experiment made what the page shows.
    """
    if not results.is_experiment:
        return {}
    facts = shared_facts(results.manifests)
    return {"again": again_text(results), "facts": facts, "experiment": results.experiment_text}


def _facts(manifest: Manifest) -> dict[str, str]:
    """The environment of a cell, flat; empty for a cell that never ran."""
    environment = manifest.environment
    if not environment:
        return {}
    machine = environment.get("machine", {})
    sources = environment.get("sources", {})
    facts = {
        "command": environment.get("command"),
        "commit": environment.get("commit"),
        **{name: machine.get(name) for name in ("system", "cpu", "kernel", "cores")},
        "engine": environment.get("engine"),
        **environment.get("versions", {}),
        **{f"source of {manifest.cell.plugins.get(kind, kind)}": digest[:12] for kind, digest in sources.items()},
    }
    return {name: str(value) for name, value in facts.items() if value}


def report_to_json(report: Report) -> dict[str, Any]:
    """The whole report as plain data. ``harness report --json`` prints it by `report_text`.

    Raises:
        SchemaError: A file is damaged or written by a newer version.
    """
    results = report.results
    data = results.to_json()
    for told, comparison in zip(data["combinations"], results.combinations, strict=True):
        learning = results.learning(comparison)
        told["learning"] = learning and learning.to_json()
    data["evaluation_returns"] = [matrix.to_json() for matrix in results.returns]
    data["ranking"] = report.ranked.to_json()
    data["notes"] = [*results.said, *results.notes]
    for told, manifest in zip(data["cells"], told_manifests(results), strict=True):
        told |= {"status": manifest.status, "reason": manifest.reason}
    data |= standing_to_json(standing_of(results))
    if report.chosen:
        data["choosing"]["told"] = report.chosen[0].title
    data |= {name: section.data for name, section in report.sections.items()}
    data |= {"reward_terms": [it.to_json() for it in results.terms]} if results.terms else {}
    data |= {"alone": [it.to_json() for it in results.alone]} if results.alone else {}
    data["facts"] = [asdict(it) for it in report.short if it.kind != "command"]
    return data


def report_text(report: Report) -> str:
    """What ``harness report --json`` prints, and what ``results.json`` of a summary holds."""
    return json.dumps(report_to_json(report), indent=1, allow_nan=False)
