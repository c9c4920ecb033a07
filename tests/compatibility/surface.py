"""The public surface, as it was recorded: every name with its signature.

``python -m tests.compatibility.surface`` records it anew. It does so once docs/plugins.md names what changed.
"""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
sys.path.insert(0, str(ROOT / "docs" / "site"))

from generated_pages import PUBLIC, signatures  # noqa: E402 - a module of the site

RECORD, PAGE = Path(__file__).with_name("surface.txt"), ROOT / "docs" / "plugins.md"
HEADING = "### Changes"


def surface():
    """A line for each public name of today, with its signature."""
    return [line for module in PUBLIC for line in signatures(module)]


def unexplained(recorded, today, page):
    """The names that appeared, left or changed their signature, and that no line of `page` under "Changes" has."""
    _, _, told = page.partition(f"\n{HEADING}\n")
    explained = set(re.findall(r"[\w.]+", re.split(r"^#", told, flags=re.MULTILINE)[0]))
    return sorted({line.partition("(")[0] for line in set(recorded) ^ set(today)} - explained)


def main():
    """Write the record, or say which names docs/plugins.md has to explain first."""
    today = surface()
    if missing := unexplained(RECORD.read_text().splitlines(), today, PAGE.read_text()):
        sys.exit(f"docs/plugins.md, {HEADING[4:]}: write a line for {', '.join(missing)}")
    RECORD.write_text("\n".join(today) + "\n")


if __name__ == "__main__":
    main()
