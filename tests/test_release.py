"""What a release needs besides a build: one version everywhere, and workflows whose targets exist."""

import re
import tomllib
from pathlib import Path

ROOT = Path(__file__).parents[1]


def test_citation_names_the_version_that_is_built():
    """CITATION.cff and pyproject.toml."""
    version = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]
    assert f"\nversion: {version}\n" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")


def test_workflows_call_targets_that_there_are():
    """Of the Makefile."""
    targets = set(re.findall(r"^(\w+):", (ROOT / "Makefile").read_text(encoding="utf-8"), re.MULTILINE))
    called = re.findall(r"make ([a-z ]+)", "".join(path.read_text() for path in ROOT.glob(".github/workflows/*.yml")))
    assert called
    assert {name for names in called for name in names.split()} <= targets
