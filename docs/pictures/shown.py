"""Takes out of committed records the figures that no page shows, and their lines: ``shown.py FOLDER``."""

import re
import sys
from pathlib import Path

ROOT = Path(__file__).parents[2]
PICTURE = re.compile(r"\n\n!\[[^\]]*\]\(([^)]*)\)(?=\n)")


def unshown(folder: Path) -> list[Path]:
    """The figures below a folder of records that neither README nor a page of the documentation shows."""
    pages = [ROOT / "README.md", *(ROOT / "docs").rglob("*.md")]
    text = "".join(page.read_text(encoding="utf-8") for page in pages if "generated" not in page.parts)
    return [path for path in sorted(folder.rglob("*.svg")) if path.resolve().relative_to(ROOT).as_posix() not in text]


def keep_shown(folder: Path) -> None:
    """Remove the others, and the lines of ``summary.md`` that show them."""
    for figure in unshown(folder):
        figure.unlink()
    page = folder / "summary.md"
    kept = PICTURE.sub(lambda line: line[0] if (folder / line[1]).is_file() else "", page.read_text(encoding="utf-8"))
    page.write_text(kept, encoding="utf-8")


if __name__ == "__main__":
    keep_shown(Path(sys.argv[1]))
