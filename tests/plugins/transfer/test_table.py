from io import StringIO

import pytest
from rich.console import Console

from harness.report.page.html import write_html
from harness_plugins.transfer import load_transfers
from harness_plugins.transfer.shown import transfer_table


@pytest.mark.parametrize("width", [60, 80, 100])
def test_terminal_has_every_number_whole(transferred, width):
    """Success at home and away, the drop, the return, what failed, and how rough it is."""
    output = StringIO()
    Console(file=output, width=width).print(transfer_table(load_transfers(transferred)))
    text = " ".join(output.getvalue().split())
    for part in ("75.0% *", "0.0%", "75.0 pp", "sac · arp · fd100 · fd100-reach"):
        assert part in text
    assert "mujoco in pybullet: 1 of 3 failed" in text
    assert "failed: mujoco · sac · arp · seed 1 in pybullet: it <b>fell</b>" in text
    assert "…" not in text


def test_page_has_a_section(transferred, tmp_path):
    """A cell for each pair, the home framed, tinted by its share; reasons are shown, not interpreted."""
    write_html(transferred, tmp_path / "report.html")
    page = (tmp_path / "report.html").read_text()
    section = page[page.index('<h3 id="transfer">') : page.index('<section aria-labelledby="cells">')]
    assert section.count('class="home" style="--share: 0.750"') == 2
    assert section.count('style="--share: 0.000"') == 2
    assert "drop 75.0 pp" in section
    assert "it &lt;b&gt;fell&lt;/b&gt;" in section


def test_page_without_transfer_has_no_section(build, tmp_path):
    """Nothing is said of what nobody asked."""
    write_html(build(), tmp_path / "report.html")
    assert 'id="transfer"' not in (tmp_path / "report.html").read_text()
