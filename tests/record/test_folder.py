"""The folder of a cell: hidden while it grows, named when it is complete."""

from harness.record import partial_folder
from harness.record.folder import evaluation_files


def test_partial_folder_is_hidden_beside(tmp_path):
    """On the same file system, so that a rename completes it, and no result by its name."""
    assert partial_folder(tmp_path / "abc") == tmp_path / ".abc.partial"


def test_evaluations_come_in_order_of_their_steps(tmp_path):
    """As numbers, and without what a killed process was writing."""
    (tmp_path / "evaluations").mkdir()
    for name in ("1000.parquet", "200.parquet", ".1200.parquet"):
        (tmp_path / "evaluations" / name).touch()
    assert list(evaluation_files(tmp_path)) == [200, 1000]
