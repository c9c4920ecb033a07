"""Finds comparisons whose cells were made by several versions of one plugin."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NamedTuple

from harness.hookspecs import NOUNS
from harness.record.manifest import SHOWN_DIGITS, Manifest


class Mixture(NamedTuple):
    """A plugin whose source files were not the same for all cells of one comparison."""

    kind: str
    name: str
    """The name of the plugin, or the path of a robot's files."""
    cells: Mapping[str, int]
    """How many cells each version made, by the SHA-256 of its files. The version that made most comes first."""

    @property
    def text(self) -> str:
        """One sentence."""
        (main, _), *others = self.cells.items()
        hashes = ", ".join(digest[:SHOWN_DIGITS] for digest, _ in others)
        other, total = sum(count for _, count in others), sum(self.cells.values())
        return (
            f"{other} of {total} cells {'was' if other == 1 else 'were'} made by another {self.name} "
            f"({hashes}; the others {main[:SHOWN_DIGITS]}): they are not the same {NOUNS[self.kind]}"
        )

    def to_json(self) -> dict[str, Any]:
        """Plain data."""
        return {"kind": self.kind, "name": self.name, "cells": dict(self.cells)}


def mixtures_of(manifests: Iterable[Manifest]) -> tuple[Mixture, ...]:
    """The mixtures among the done cells of one comparison. A cell without a recorded hash is left out."""
    started: dict[tuple[str, str], dict[str, list[str]]] = {}
    for manifest in manifests:
        recorded = manifest.environment.get("sources", {})
        for kind, name in manifest.cell.plugins.items():
            if kind in recorded:
                started.setdefault((kind, name), {}).setdefault(recorded[kind], []).append(manifest.started)
    return tuple(
        Mixture(kind, name, _counts(versions)) for (kind, name), versions in started.items() if len(versions) > 1
    )


def _counts(started: Mapping[str, Sequence[str]]) -> dict[str, int]:
    """How many cells each version made. Of two versions that made as many, the newer one comes first."""
    order = sorted(started, key=lambda version: (len(started[version]), max(started[version])), reverse=True)
    return {version: len(started[version]) for version in order}
