"""Tables of text that other programs write, cell by cell."""

import gzip
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_array_equal

from harness.errors import SchemaError
from harness.log import require_columns
from harness.log.text_table import NOTHING, head_of, parse_table, read_text
from tests.refusals import refused

PATH = Path("table.csv")


def test_cells_are_kept_with_their_lines():
    """Blank lines are no rows, and a cell in quotes may hold commas and line breaks."""
    table = parse_table(PATH, 'a,b\n1,"x,y"\n\n2,"x\ny"\n3,z\n')
    assert table.names == ("a", "b")
    assert table.cells["b"] == ["x,y", "x\ny", "z"]
    assert table.lines == [2, 5, 6]


def test_a_header_that_comes_again_is_no_row():
    """Somebody has appended to the file."""
    table = parse_table(PATH, "a,b\n1,2\na,b\n3,4\n")
    assert table.cells["a"] == ["1", "3"]
    assert table.lines == [2, 4]


@pytest.mark.parametrize("ending", ["\n", "\r\n", "\r"])
def test_lines_may_end_in_three_ways(ending):
    """Of Unix, of Windows, and of very old files."""
    table = parse_table(PATH, ending.join(["a,b", "1,2", "3,4", ""]))
    assert table.numbers("b").tolist() == [2.0, 4.0]
    assert table.cut == 0


def test_a_last_line_without_an_end_is_left_out():
    """Its number and the reason are told."""
    table = parse_table(PATH, "a,b\n1,2\n3,4")
    assert table.cells["a"] == ["1"]
    assert table.notes == ("line 3 is cut off, or is being written: it is left out",)


def test_a_last_line_in_quotes_may_end_with_nothing():
    """As exports of pages do; within a quote it is cut all the same."""
    assert parse_table(PATH, '"a","b"\n"1","2"').cells["b"] == ["2"]
    with pytest.raises(SchemaError, match="line 2: unexpected end of data"):
        parse_table(PATH, '"a","b"\n"1","2')


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "has no header"),
        ("a,b", "a header that is cut off"),
        ("a,a\n1,2\n", "names a column twice"),
        ("a,b\n1\n", "line 2: it has 1 cells, and there are 2 columns"),
        ("a,b\n1,2,3\n", "line 2: it has 3 cells, and there are 2 columns"),
    ],
)
def test_what_is_no_table_is_refused(text, why):
    """With the line, where there is one."""
    with pytest.raises(SchemaError, match=why):
        parse_table(PATH, text)


def test_numbers_are_those_that_python_reads():
    """True and False too; underscores are no digits here."""
    assert parse_table(PATH, "a\n1\n-2.5e-3\n True \nfalse\n").numbers("a").tolist() == [1.0, -0.0025, 1.0, 0.0]
    with pytest.raises(SchemaError, match="line 2: column 'a' holds 1_000, which is no number"):
        parse_table(PATH, "a\n1_000\n").numbers("a")


@pytest.mark.parametrize("cell", ["inf", "-inf", "1e200", "x"])
def test_what_is_no_finite_number_is_refused(cell):
    """Also where cells may lack a value."""
    with pytest.raises(SchemaError, match=f"line 3: column 'a' holds {cell}"):
        parse_table(PATH, f"a,b\n1,\n{cell},\n").numbers("a", ("",))


def test_cells_that_may_lack_a_value_are_nan():
    """Empty ones, and those that say so."""
    table = parse_table(PATH, "a,b\n1,\nnan,\n,\nNone,\n")
    assert np.isnan(table.numbers("a", NOTHING)).tolist() == [False, True, True, True]
    with pytest.raises(SchemaError, match="line 3: column 'a' holds nan"):
        table.numbers("a")


def test_counts_and_truths_are_what_they_are():
    """A value under the name of another column is found by them."""
    table = parse_table(PATH, "n,s\n0,1\n2.5,0.5\n")
    with pytest.raises(SchemaError, match=r"line 3: column 'n' counts from 0, and holds 2\.5"):
        table.counts("n")
    with pytest.raises(SchemaError, match=r"line 3: column 's' is 0 or 1, and holds 0\.5"):
        table.truths("s")


def test_a_file_that_is_no_text_is_refused(tmp_path):
    """In one line that names it."""
    path = tmp_path / "table.csv"
    path.write_bytes(b"a,b\n\xff\xfe,1\n")
    with pytest.raises(SchemaError, match=r"table\.csv is no readable table"):
        read_text(path)


def test_a_header_is_read_from_the_file_where_the_head_is_too_short(tmp_path):
    """And is nothing where the file cannot be read."""
    path = tmp_path / "table.csv"
    header = ",".join(f"column {number}" for number in range(1000)) + "\n"
    path.write_text(header)
    head = path.read_bytes()[:4096]
    assert head_of(path, head) == header
    path.unlink()
    assert head_of(path, head) == head_of(path, b"") == ""


TEXT = "a;b\n1,5;2\n"


@pytest.mark.parametrize(
    ("data", "numbers"),
    [
        (b"a,b\n1.5,2\n", [1.5]),
        (b"\xef\xbb\xbfa\tb\r\n1.5\t2\r\n", [1.5]),
        ("a,b\n1.5,2\n".encode("utf-16"), [1.5]),
        (gzip.compress(b"a,b\n1.5,2\n"), [1.5]),
        (gzip.compress(b"a,b\n1.5,2\n2.5,3\n" * 99)[:-4], [1.5, 2.5] * 2),
        (b'{"a": 1.5, "b": {"c": null}}\n{"a": 2.5, "x": [1]}\n', [1.5, 2.5]),
        (b'{"a": 1.5}\n{"a": 2.5', [1.5]),
        (b'[{"a": 1.5}, {"a": NaN}]', [1.5, np.nan]),
        (TEXT.encode(), [1.5]),
    ],
    ids=["commas", "tabs", "UTF-16", "gzip", "gzip, cut", "JSON lines", "JSON lines, cut", "a list", "decimal commas"],
)
def test_a_table_is_read_however_it_is_packed(tmp_path, data, numbers):
    """As text or as JSON."""
    path = tmp_path / "table"
    path.write_bytes(data)
    table = parse_table(path, read_text(path))
    assert_array_equal(table.numbers("a", NOTHING)[: len(numbers)], numbers)
    assert ("comma" in "".join(table.notes)) == (data == TEXT.encode())
    is_cut = data.endswith(b"2.5") or (data.startswith(b"\x1f\x8b") and len(numbers) > 1)
    assert ("left out" in "".join(table.notes)) == is_cut


def test_a_count_with_a_decimal_comma_is_refused():
    """It may be a thousand."""
    with pytest.raises(SchemaError, match="line 2: column 'n' counts from 0, and holds 1,000"):
        parse_table(PATH, "n;x\n1,000;1\n").counts("n")


def test_names_in_objects_are_joined():
    """As RLlib nests its results."""
    assert parse_table(PATH, '{"a": {"b": {"c": 1}, "d": true}}\n').cells == {"a/b/c": ["1"], "a/d": ["True"]}
    with pytest.raises(SchemaError, match="line 2: it is no object"):
        parse_table(PATH, '{"a": 1}\n[2]\n')


def test_columns_that_a_user_named_have_to_be_there():
    """The message has what is there, and the nearest."""
    require_columns(PATH, ["reward", "length"], "reward", "")
    with refused(r"has no 'rewrd'\. It has: reward, length\. Did you mean 'reward'"):
        require_columns(PATH, ["reward", "length"], "rewrd")
