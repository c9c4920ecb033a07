import json
from types import SimpleNamespace

import pytest

from harness.errors import PluginError
from harness.report import FactsTable, Report
from harness.report.page.html import write_html
from harness_plugins.committed import committed_table, write_summary
from harness_plugins.transfer.matrix import TransferSection
from tests.report.conftest import printed, squeezed


@pytest.mark.parametrize("width", [60, 80, 100])
def test_terminal_has_every_number_whole(transferred, width):
    """Success at home and away, the drop, the return, what failed, and how rough it is."""
    text = " ".join(printed(FactsTable(Report(transferred).short), width).split())
    for part in ("mujoco: success 75.0% 0.0%", "drop 75.0", "sac · arp · fd100 · fd100-reach"):
        assert part in text
    assert "mujoco in pybullet: 1 of 3 failed" in text
    assert "failed: mujoco · sac · arp · seed 1 in pybullet: it <b>fell</b>" in text
    assert "…" not in text


def test_page_has_a_section(transferred, tmp_path):
    """The same table; reasons are shown, not interpreted."""
    write_html(Report(transferred), tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    section = page[page.index("Transfer between simulators</h3>") : page.index('<section aria-labelledby="cells">')]
    assert section.count('<td class="number" data-label="pybullet">75.0</td>') == 2
    assert "it &lt;b&gt;fell&lt;/b&gt;" in section


def test_summary_and_records_have_it(transferred, tmp_path):
    """Who reads them later misses no drop."""
    write_summary(transferred, tmp_path / "kept")
    assert "| mujoco: success | 75.0% | 0.0% |" in (tmp_path / "kept" / "summary.md").read_text()
    assert "the largest drop of success is 75.0" in squeezed(printed(committed_table(tmp_path / "kept")))
    told = json.loads((tmp_path / "kept" / "results.json").read_text())
    assert told["transfer"]["combinations"][0]["drop"][0][1]["value"] == 0.75


def test_page_without_transfer_has_no_section(build, tmp_path):
    """Nothing is said of what nobody asked."""
    write_html(Report(build()), tmp_path / "report.html")
    assert "Transfer between simulators" not in (tmp_path / "report.html").read_text()


def test_what_a_section_of_0_3_shows_ends_in_what_to_write(transferred, monkeypatch):
    """It had a table for the terminal and HTML for the page."""
    old = SimpleNamespace(style="", to_json=dict, table=str, html=str)
    monkeypatch.setattr(TransferSection, "show", lambda section, results: old)
    with pytest.raises(PluginError, match=r"'transfer'.* shows a SimpleNamespace; write harness\.results\.Shown\("):
        _ = Report(transferred).short
