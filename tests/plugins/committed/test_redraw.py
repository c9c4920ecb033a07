"""Figures of records, drawn again from the records alone."""

import json
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from harness.errors import UsageError
from harness_plugins.committed.records import write_summary
from harness_plugins.committed.redraw import redraw

REFERENCE = Path(__file__).parents[3] / "results" / "reference"
RECORDS = sorted(path.parent for path in REFERENCE.glob("**/results.json"))


def files_of(folder: Path) -> dict[str, bytes]:
    """Every file by its path within the folder."""
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


@pytest.fixture
def summary(build: Callable, tmp_path: Path) -> Path:
    """Of a small experiment whose policies were evaluated while they learned."""
    write_summary(build(proposed={"arp": (9, 30), "dense": (5, 34)}, learned={10: 1}), tmp_path / "mine")
    return tmp_path / "mine"


def test_a_summary_is_drawn_again_to_the_byte(summary: Path):
    """Also what was lost, and what somebody changed."""
    before = files_of(summary)
    first, second, *_ = sorted((summary / "figures").iterdir())
    first.unlink()
    second.write_bytes(second.read_bytes().replace(b"#", b"#f"))
    redraw(summary)
    assert files_of(summary) == before


def test_what_the_page_does_not_show_is_not_drawn(summary: Path):
    """Its line was taken out."""
    page = summary / "summary.md"
    lines = [line for line in page.read_text().splitlines() if "overview.svg" not in line]
    page.write_text("\n".join(lines) + "\n")
    redraw(summary)
    assert "figures/overview.svg" not in files_of(summary)


def test_a_figure_in_which_nothing_happens_becomes_words(summary: Path):
    """On the page too, once."""
    record = json.loads((summary / "results.json").read_text())
    for told in record["combinations"]:
        for points in (told["learning"]["metrics"]["success_rate"][who] for who in ("baseline", "proposed")):
            for point in points:
                point["mean"] = 0.0
    (summary / "results.json").write_text(json.dumps(record))
    redraw(summary)
    redraw(summary)
    assert not list((summary / "figures").glob("*.learning.svg"))
    assert (summary / "summary.md").read_text().count("while learning: 0.0% under both rewards at each of 2") == 2


def test_a_record_without_curves_is_refused(summary: Path):
    """Nothing is written then."""
    (summary / "runs.parquet").unlink()
    before = files_of(summary)
    with pytest.raises(UsageError, match=r"lacks runs\.parquet"):
        redraw(summary)
    assert files_of(summary) == before


@pytest.mark.parametrize("name", ["results.json", "figures.json", "runs.parquet"])
def test_a_damaged_record_is_refused(summary: Path, name: str):
    """In one line, and nothing is written."""
    (summary / name).write_bytes((summary / name).read_bytes()[:20])
    before = files_of(summary)
    with pytest.raises(UsageError, match="is no readable record"):
        redraw(summary)
    assert files_of(summary) == before


def test_no_folder_is_a_usage_error():
    """Nothing was drawn, and nobody should think so."""
    ended = subprocess.run(
        [sys.executable, "-m", "harness_plugins.committed.redraw"], capture_output=True, text=True, check=False
    )
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr.startswith("Name the folders")


def test_a_newer_version_is_told_in_one_line(summary: Path):
    """With exit status 2, as of every command."""
    told = (summary / "figures.json").read_text()
    (summary / "figures.json").write_text(told.replace('"format": 1', '"format": 2'))
    command = [sys.executable, "-m", "harness_plugins.committed.redraw", str(summary)]
    ended = subprocess.run(command, capture_output=True, text=True, check=False)
    assert (ended.returncode, ended.stdout) == (2, "")
    assert ended.stderr.endswith("figures.json' was written by a newer version: update this one\n")


@pytest.mark.parametrize("folder", RECORDS, ids=lambda it: it.relative_to(REFERENCE).as_posix())
def test_the_committed_figures_are_those_of_the_committed_records(folder: Path, tmp_path: Path):
    """To the byte."""
    copy = tmp_path / folder.name
    shutil.copytree(folder, copy)
    redraw(copy)
    assert files_of(copy) == files_of(folder)
