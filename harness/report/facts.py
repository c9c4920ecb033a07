"""Facts from the manifests of the cells that ran: versions, machine, engine, commit, command, sources."""

from collections import Counter
from collections.abc import Iterable
from typing import Any, NamedTuple

from harness.record.manifest import Manifest
from harness.report.rows.comparison import again_text
from harness.results import Results


class Fact(NamedTuple):
    """A fact from the manifests, and in how many cells it holds if not in all."""

    name: str
    value: str
    cells: str


def shared_facts(manifests: Iterable[Manifest]) -> list[Fact]:
    """Versions, machine, engine, commit, command, sources of all cells that ran; a line each, or more."""
    counts: dict[str, Counter[str]] = {}
    for manifest in manifests:
        for name, value in _facts(manifest).items():
            counts.setdefault(name, Counter())[value] += 1
    return [
        Fact(name, value, f"{count} of {values.total()} cells" if len(values) > 1 else "")
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
        **{name: machine.get(name) for name in ("system", "cpu", "cores")},
        "engine": environment.get("engine"),
        **environment.get("versions", {}),
        **{f"source of {manifest.cell.plugins.get(kind, kind)}": digest[:12] for kind, digest in sources.items()},
    }
    return {name: str(value) for name, value in facts.items() if value}
