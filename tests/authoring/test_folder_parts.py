"""A folder in parts."""

from harness.executor import add_parts, parts_of

PART_BYTES = 4 * 2**20


def test_a_folder_comes_together_again(tmp_path):
    """Large, empty and nested files; a link is left out."""
    files = {"trace": bytes(range(256)) * (PART_BYTES // 100), "empty": b"", "policy/weights": b"w" * PART_BYTES}
    for name, content in files.items():
        path = tmp_path / "there" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(content)
    (tmp_path / "there" / "link").symlink_to("trace")
    parts = list(parts_of(tmp_path / "there"))
    assert max(len(part.content) for part in parts) == PART_BYTES
    add_parts(tmp_path / "here", parts)
    here = tmp_path / "here"
    assert {path.relative_to(here).as_posix(): path.read_bytes() for path in here.rglob("*") if path.is_file()} == files


def test_a_folder_that_is_not_there_has_no_parts(tmp_path):
    """As before a cell has begun."""
    assert list(parts_of(tmp_path / "nothing")) == []
