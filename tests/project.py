"""Where the project's own files are."""

from pathlib import Path

ROOT = Path(__file__).parents[1]


def page_of(name):
    """The text of a page of the documentation."""
    return (ROOT / "docs" / f"{name}.md").read_text()
