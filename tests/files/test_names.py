"""Names that stand in a file and become paths."""

from harness.files.bounded import is_inside, is_plain, twins


def test_names_of_files_are_plain(subtests):
    """Letters of all languages, blanks, dots."""
    for name in ["trace.parquet", "Größe", "a b", "..a", ".hidden", "x" * 255]:
        with subtests.test(name=name):
            assert is_plain(name)


def test_what_leads_elsewhere_is_not_plain(subtests):
    """On any system; nor what no system takes for a name."""
    for name in ["", ".", "..", "a/b", "/a", "a\\b", "C:a", "C:\\a", "a\0", "a\n", "\x1b[2J", "\ud800", "é" * 128]:
        with subtests.test(name=name):
            assert not is_plain(name)


def test_paths_that_may_leave_the_folder_are_not_inside(subtests):
    """Each part is a plain name."""
    for path in ["..", "a/..", "../a", "a//b", "/a", "a/", "a/./b", "a/../../b"]:
        with subtests.test(path=path):
            assert not is_inside(path)
            assert is_inside("a/b/c")


def test_twins_are_one_file_on_some_systems():
    """Letters of another case, accents written as marks of their own."""
    assert twins(["a/B", "c", "A/b", "é", "e\u0301"]) == ["A/b", "e\u0301"]
    assert twins(["a", "b"]) == []
