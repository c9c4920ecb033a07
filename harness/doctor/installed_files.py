"""Compares an installation with what its wheel held."""

import base64
import hashlib
import json
from importlib.metadata import Distribution, PackageNotFoundError, PackagePath, distribution
from pathlib import Path

from harness.registry.spec import OURS

REMEDY = "install it again: pip install --force-reinstall --no-deps, and what you installed it from"
CACHE = "__pycache__"


def file_lines(name: str = OURS) -> list[str]:
    """One line for each file of a distribution that is missing or was changed since it was installed.

    An editable installation has no files of its own: it uses the checkout, and so does one that is not installed. Nor
    does the metadata that a build leaves in a checkout list installed files: it has no RECORD.
    """
    try:
        found = distribution(name)
    except PackageNotFoundError:
        return []
    if found.read_text("RECORD") is None or _is_editable(found):
        return []
    problems = [(str(path), _problem(path)) for path in found.files or () if CACHE not in path.parts]
    return [f"file {path} {problem}: {REMEDY}" for path, problem in problems if problem]


def _is_editable(found: Distribution) -> bool:
    told = json.loads(found.read_text("direct_url.json") or "{}")
    return bool(told.get("dir_info", {}).get("editable"))


def _problem(path: PackagePath) -> str:
    """What is wrong with a file that RECORD names; empty if nothing is."""
    place = Path(path.locate())
    if not place.is_file():
        return "is missing"
    if path.hash is None:  # RECORD itself
        return ""
    digest = hashlib.new(path.hash.mode, place.read_bytes()).digest()
    told = base64.urlsafe_b64encode(digest).decode().rstrip("=")
    return "" if told == path.hash.value else "is not what was installed"
