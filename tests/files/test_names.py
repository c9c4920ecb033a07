"""Names that stand in a file and become paths."""

import pytest

from harness.files.names import is_inside, is_plain, twins


@pytest.mark.parametrize("name", ["trace.parquet", "Größe", "a b", "..a", ".hidden", "x" * 255])
def test_names_of_files_are_plain(name: str):
    """Letters of all languages, blanks, dots."""
    assert is_plain(name)


@pytest.mark.parametrize(
    "name", ["", ".", "..", "a/b", "/a", "a\\b", "C:a", "C:\\a", "a\0", "a\n", "\x1b[2J", "\ud800", "é" * 128]
)
def test_what_leads_elsewhere_is_not_plain(name: str):
    """On any system; nor what no system takes for a name."""
    assert not is_plain(name)


@pytest.mark.parametrize("path", ["..", "a/..", "../a", "a//b", "/a", "a/", "a/./b", "a/../../b"])
def test_paths_that_may_leave_the_folder_are_not_inside(path: str):
    """Each part is a plain name."""
    assert not is_inside(path)
    assert is_inside("a/b/c")


def test_twins_are_one_file_on_some_systems():
    """Letters of another case, accents written as marks of their own."""
    assert twins(["a/B", "c", "A/b", "é", "e\u0301"]) == ["A/b", "e\u0301"]
    assert twins(["a", "b"]) == []
