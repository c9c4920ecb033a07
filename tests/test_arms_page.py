"""The public arms: all of the list are measured, what is said of them holds, and the pages say what was measured."""

import math
import sys
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip("pinocchio")
pytest.importorskip("mujoco")
sys.path.insert(0, str(Path(__file__).parents[1] / "experiments/arms"))
import measure as measure_arms

from tests.project import ROOT, page_of

ARMS = tomllib.loads(measure_arms.ARMS.read_text())["arm"]
RECORD = ROOT / "results/reference/arms/arms.csv"
if not RECORD.exists():
    pytest.skip("`make arms` writes the record", allow_module_level=True)
ROWS = measure_arms.read(RECORD)


def test_every_arm_of_the_list_is_measured():
    """In its order, from the same file."""
    assert [(row.name, row.file) for row in ROWS] == [(arm["name"], arm["file"]) for arm in ARMS]
    assert len({row.name for row in ROWS}) == 75


def test_what_loads_is_right():
    """The tip to a picometre; trained in every simulator; held against one another; each refusal is a sentence."""
    loaded = [row for row in ROWS if row.joints]
    assert len(loaded) >= 70
    for row in loaded:
        assert row.tip_error <= 1e-12, row
        assert row.trains.split() == list(measure_arms.SIMULATORS), row
        assert math.isfinite(row.apart), row
    for row in ROWS:
        assert "traceback" not in row.refused.lower(), row
        assert bool(row.refused) == (not row.joints), row
        assert "\n" not in row.refused


def test_pages_say_what_was_measured(tmp_path):
    """The page beside the record is what the command writes, and robots.md counts its rows."""
    measure_arms.write(tmp_path / RECORD.name, ROWS)
    assert (tmp_path / RECORD.name).read_text() == RECORD.read_text()
    assert (tmp_path / "README.md").read_text() == RECORD.with_name("README.md").read_text()
    loaded = sum(bool(row.joints) for row in ROWS)
    assert f"**{loaded} of {len(ROWS)} load and are right**" in page_of("robots")


def test_a_table_shows_what_fails():
    """An arm that is refused, that trains nowhere, or that parity refuses is seen to be."""
    row = ROWS[0]
    for changed, cell in [
        ({"joints": 0}, "| refused |"),
        ({"trains": "mujoco"}, "| mujoco |"),
        ({"trains": ""}, "| no |"),
        ({"apart": math.nan}, "| refused |"),
    ]:
        assert cell not in measure_arms.table([row])
        assert cell in measure_arms.table([replace(row, **changed)])


def test_a_robot_toml_is_what_the_list_says():
    """Every key of it, in TOML."""
    for arm in ARMS:
        assert tomllib.loads(measure_arms.robot_toml(arm)) == {"urdf": arm["file"], **arm.get("robot", {})}
