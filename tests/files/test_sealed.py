"""JSON files that carry the digest of their own bytes."""

import pytest
from hypothesis import given, strategies as st

from harness.errors import NewerFormat, SchemaError
from harness.files.bounded import read_sealed, seal, unseal

JSON = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False, allow_infinity=False) | st.text(),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(), inner, max_size=3),
    max_leaves=10,
)


@given(st.dictionaries(st.text().filter(lambda key: key != "digest"), JSON, max_size=5))
def test_content_comes_back(content):
    """Whatever JSON can say."""
    assert unseal(seal(content)) == content


def test_every_flipped_bit_is_found():
    """One bit of any byte: white space, keys, values, the digest itself."""
    text = seal({"format": 2, "cells": [{"seed": 3, "label": "\u03b7 \u00e9"}], "x": [1.5, None]})
    for place in range(len(text) * 8):
        flipped = bytearray(text)
        flipped[place // 8] ^= 1 << place % 8
        with pytest.raises(ValueError, match=r"digest|codec|JSON|Expecting|Invalid|Extra|property|delimiter"):
            unseal(bytes(flipped))


def test_file_of_an_earlier_format_needs_no_digest(tmp_path):
    """Version 0.1 wrote none."""
    (tmp_path / "plan.json").write_text('{"cells": []}')
    assert read_sealed(tmp_path / "plan.json", "plan", newest=2, since=2) == {"cells": []}


def test_format_that_is_flipped_to_an_earlier_one_is_found(tmp_path):
    """A sealed file stays one, whatever it says of its format."""
    text = seal({"format": 2, "cells": []}).replace(b'"format": 2', b'"format": 1')
    (tmp_path / "plan.json").write_bytes(text)
    with pytest.raises(SchemaError, match=r"plan\.json is no readable plan: ValueError: it is not what was written"):
        read_sealed(tmp_path / "plan.json", "plan", newest=2, since=2)


def test_newer_format_is_no_damage(tmp_path):
    """It is told apart: nothing may replace it."""
    (tmp_path / "plan.json").write_text('{"format": 3}')
    with pytest.raises(NewerFormat, match=r"plan\.json has format 3, this version reads up to 2"):
        read_sealed(tmp_path / "plan.json", "plan", newest=2, since=2)


def test_what_is_no_sealed_object_is_refused(tmp_path_factory, subtests):
    """The line names the file."""
    for content in ["[]", "3", "null", '{"format": "2"}', '{"format": 2}', "{"]:
        with subtests.test(content=content):
            tmp_path = tmp_path_factory.mktemp("case")
            (tmp_path / "plan.json").write_text(content)
            with pytest.raises(SchemaError, match=r"plan\.json is no readable plan"):
                read_sealed(tmp_path / "plan.json", "plan", newest=2, since=2)


@given(st.dictionaries(st.text().filter(lambda key: key != "digest"), JSON, max_size=5))
def test_a_flat_file_says_the_same(content):
    """Lists of numbers on one line; no text in it changes."""
    assert unseal(seal(content, is_flat=True)) == content


def test_a_flat_file_has_its_numbers_in_a_line():
    """Those of an inner list too; a text that looks like a list stays."""
    lines = seal({"a": [1, 2.5, None], "b": [[1], [2]], "c": "[ 1 ]"}, is_flat=True).decode().splitlines()
    assert ' "a": [1, 2.5, null],' in lines
    assert "  [1]," in lines
    assert ' "c": "[ 1 ]",' in lines
