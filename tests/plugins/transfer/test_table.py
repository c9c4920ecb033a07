from dataclasses import replace
from io import StringIO

import numpy as np
import pytest
from rich.console import Console

from harness.policy import SquashedGaussian
from harness.record.folder import EVALUATION, POLICY
from harness.registry.choice import Choice
from harness.report.page.html import write_html
from harness_plugins.transfer.matrix import load_transfers
from harness_plugins.transfer.record import TRANSFER, TransferRecord, policy_digest, simulator_id
from harness_plugins.transfer.shown import transfer_table


@pytest.fixture
def transferred(build):
    """An experiment whose policies were also in pybullet, where one evaluation failed."""
    results = build()
    for cell in results.done_cells:
        home = results.store.cell_folder(cell)
        weights = {f"{layer}.{part}": np.ones((1, 1), np.float32) for layer in ("mean", "log_std") for part in "wb"}
        weights["mean.weight"] = np.ones((1, 1), np.float32)
        SquashedGaussian(weights, "relu", (-1.0,), (1.0,)).save(home / POLICY)
        away = Choice("pybullet", (), "pybullet")
        folder = results.folder / TRANSFER / cell.id / simulator_id(away)
        folder.mkdir(parents=True)
        record = TransferRecord(cell.id, away, policy_digest(home), status="done")
        if (cell.reward.label, cell.seed) == ("arp", 1):
            record = replace(record, status="failed", reason="it <b>fell</b>")
        else:
            (folder / EVALUATION).write_bytes((home / "random.parquet").read_bytes())
        record.write(folder)
    return results


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
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    section = page[page.index('<h3 id="transfer">') : page.index('<section aria-labelledby="cells">')]
    assert section.count('class="home" style="--share: 0.750"') == 2
    assert section.count('style="--share: 0.000"') == 2
    assert "drop 75.0 pp" in section
    assert "it &lt;b&gt;fell&lt;/b&gt;" in section


def test_page_without_transfer_has_no_section(build, tmp_path):
    """Nothing is said of what nobody asked."""
    write_html(build(), tmp_path / "report.html")
    assert 'id="transfer"' not in (tmp_path / "report.html").read_text(encoding="utf-8")
