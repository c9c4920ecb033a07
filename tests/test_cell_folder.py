"""The folder of a cell: hidden while it grows, named when it is complete."""

from pathlib import Path

from harness.cell_folder import partial_folder, publish


def test_partial_folder_is_hidden_beside(tmp_path: Path):
    """On the same file system, so that a rename completes it, and no result by its name."""
    assert partial_folder(tmp_path / "abc") == tmp_path / ".abc.partial"


def test_publish_replaces(tmp_path: Path):
    """The complete folder takes the place of the earlier one, nothing of which stays."""
    for name, file in (("cell", "old"), (".cell.partial", "new")):
        (tmp_path / name).mkdir()
        (tmp_path / name / file).touch()
    publish(partial_folder(tmp_path / "cell"), tmp_path / "cell")
    assert [path.name for path in tmp_path.iterdir()] == ["cell"]
    assert [path.name for path in (tmp_path / "cell").iterdir()] == ["new"]
