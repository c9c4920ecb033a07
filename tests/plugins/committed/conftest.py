"""Summaries of small experiment folders."""

import pytest

from harness_plugins.committed import write_summary
from tests.report.conftest import barriers, build, driver, launch, mixed, show  # noqa: F401 -- fixtures


@pytest.fixture
def summarise(build, tmp_path):  # noqa: F811
    """Builds an experiment, see `build`, and writes its summary into a folder of that name."""

    def write(name="summary", **given):
        write_summary(build(**given), tmp_path / name)
        return tmp_path / name

    return write


@pytest.fixture
def figures(tmp_path):
    """Gives the figures of a summary by what they show; of each kind one, so of one combination."""

    def draw(results):
        write_summary(results, tmp_path / "drawn")
        return {path.name.split(".")[-2]: path.read_bytes() for path in (tmp_path / "drawn" / "figures").glob("*.svg")}

    return draw
