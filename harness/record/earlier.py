"""What folders of versions 0.1 and 0.2 lack, or name otherwise: every reader gets what a folder of this version has."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType
from typing import Any

from harness.files.bounded import SUMS
from harness.record.folder import EVALUATION, RANDOM, SCORES, TRACE, digests_in

ALGORITHMS: Mapping[str, str] = MappingProxyType({"sac": "sb3-sac"})
"""The present name of each algorithm whose name in cells of 0.2 means another one now."""


def whole_manifest(data: dict[str, Any], folder: Path) -> dict[str, Any]:
    """What a ``manifest.json`` of 0.1 says. It names no digests: the files count that are there and can be read.

    Raises:
        SchemaError: A trace of a done cell cannot be read.
    """
    from harness.record.trace import read_trace  # here: no manifest of today needs traces to be read

    if "id" in data and data.get("status") == "done":
        for name in (TRACE, EVALUATION, RANDOM):
            read_trace(folder / name).rows(["reward"])
    return {**data, "files": {name: it for name, it in digests_in(folder).items() if name not in (SCORES, SUMS)}}
