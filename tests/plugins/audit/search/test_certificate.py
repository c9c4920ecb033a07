"""A certificate says exactly what was done and paid, and what is no certificate is refused in one line."""

import json
import os
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, strategies as st
from hypothesis.extra.numpy import arrays

from harness.errors import NewerFormat, SchemaError
from harness.files.bounded import seal
from harness_plugins.audit import read_certificate, write_certificate
from harness_plugins.audit.search.certificate import array_of, file_names, numbers_of
from tests.plugins.audit.search.certified import certificate_of, place_of

FLOATS = {"allow_nan": False, "allow_infinity": False}


def bits(shown):
    """All of an episode, bit for bit."""
    parts = (shown.actions, shown.paid, *shown.terms.values(), shown.success, *shown.measures.values())
    return [(part.dtype.name, part.shape, part.tobytes()) for part in parts]


def test_what_is_written_is_read(tmp_path):
    """Every bit of it, and every fact."""
    written = certificate_of()
    write_certificate(written, tmp_path / "c.json")
    read = read_certificate(tmp_path / "c.json")
    assert bits(read.shown) == bits(written.shown)
    assert read.to_json() == written.to_json()
    assert (read.place, read.answer, read.found, read.noise) == (
        written.place, written.answer, written.found, written.noise
    )  # fmt: skip


SHAPES = st.tuples(st.integers(1, 5), st.integers(1, 3))
ARRAYS = st.one_of(
    *(arrays(kind, SHAPES, elements=st.floats(width=int(kind[-2:]), **FLOATS)) for kind in ("float32", "float64")),
    *(arrays(kind, SHAPES) for kind in ("int64", "uint8")),
)


@given(ARRAYS)
def test_actions_come_back_bit_for_bit(array):
    """Through JSON, whatever the type; a zero keeps its sign."""
    again = array_of(json.loads(json.dumps(numbers_of(array))))
    assert (again.dtype, again.shape, again.tobytes()) == (array.dtype, array.shape, array.tobytes())


def test_a_float_of_32_bits_is_short():
    """As it is typed, and not with the digits of one of 64 bits."""
    assert numbers_of(np.array([[0.1], [1.0]], np.float32))["numbers"] == [0.1, 1.0]


def test_a_list_of_numbers_stands_on_one_line(tmp_path):
    """A file of 200 steps is short enough to be read."""
    write_certificate(certificate_of(), tmp_path / "c.json")
    lines = (tmp_path / "c.json").read_text().splitlines()
    assert len(lines) < 150
    assert sum(line.strip().startswith('"steps": [') for line in lines) == 1


def test_a_measure_that_is_not_told_stays_so(tmp_path):
    """NaN, which JSON has not."""
    shown = certificate_of().shown
    write_certificate(
        certificate_of(shown=replace(shown, measures={"at": np.full(20, np.nan)})), tmp_path / "c.json"
    )  # fmt: skip
    assert np.isnan(read_certificate(tmp_path / "c.json").shown.measures["at"]).all()


def test_names_of_files_sort_by_reward_and_role():
    """And are different names on every system."""
    labels = ("arp:k2=3", "arp:k2-3", "../..", "near")
    roles = ("failure", "success", "fastest")
    names = file_names([certificate_of(place=place_of(label), role=role) for label in labels for role in roles])
    assert names[:3] == [f"arp-k2-3-{role}.json" for role in roles]
    assert len(set(names)) == 12
    assert all(re.fullmatch(r"[\w-][\w.-]*", name) for name in names)


@pytest.mark.parametrize(
    ("success", "time"), [([0, 0, 0], 4), ([0, 1, 1], 2), ([1, 1, 1], 1), ([1, 0, 1], 3), ([1, 0, 0], 4)]
)
def test_success_counts_from_the_step_that_keeps_it(success, time):
    """One that is lost again is none."""
    made = certificate_of(shown=replace(certificate_of().shown, success=np.array(success, bool)))
    assert made.outcome == (f"success from step {time} on" if success[-1] else "no success")


SPOILED = {
    "a million actions": ("actions.numbers", [0.0] * 1_000_000),
    "more steps than there may be": ("paid.steps", [0.0] * 20_001),
    "numbers that do not fill the shape": ("actions.shape", [7, 3]),
    "a shape of nothing": ("actions.shape", [0, 1]),
    "a negative shape": ("actions.shape", [-20, -1]),
    "another number of steps": ("paid.steps", [1.0]),
    "a term of another length": ("paid.terms", {"near": [1.0]}),
    "a success that is 2": ("behaviour.success", [2] * 20),
    "a type that is code": ("actions.type", "object"),
    "a number beyond its type": ("actions.numbers", [1e300] * 20),
    "whole numbers beyond all": ("actions.numbers", [10**400] * 20),
    "a text for a number": ("actions.numbers", ["1"] * 20),
    "a pay of null": ("paid.steps", [None] * 20),
    "a role that is none": ("role", "../../x"),
    "a word that is none": ("answer.word", "SAFE"),
    "a name of two lines": ("place.task.label", "a\nb"),
    "a gamma of 2": ("place.gamma", 2.0),
    "a key too many": ("more", 1),
    "no actions": ("actions", ...),
    "a negative start": ("start", -1),
    "a list": ("place", []),
    "a start that is true": ("start", True),
    "noise of NaN": ("noise", [{"noise": "NaN", "paid": 1.0, "success": 0.0, "episodes": 1}]),
    "an arm's picture that is too long": (
        "drawn", {"qpos": {"type": "float64", "shape": [2, 1], "numbers": [0.0, 0.0]}}
    ),
}  # fmt: skip


@pytest.mark.parametrize(("keys", "to"), SPOILED.values(), ids=SPOILED)
def test_a_hostile_file_is_refused_in_a_line(tmp_path, keys, to):
    """However well its digest was made."""
    at = data = json.loads(json.dumps(certificate_of().to_json()))
    *above, last = keys.split(".")
    for key in above:
        at = at[key]
    at[last] = to
    if to is ...:
        del at[last]
    (tmp_path / "c.json").write_bytes(seal(data))
    with pytest.raises(SchemaError) as error:
        read_certificate(tmp_path / "c.json")
    assert "\n" not in str(error.value)
    assert str(error.value).startswith(f"{tmp_path / 'c.json'} is no readable certificate: ")
    assert len(str(error.value)) < 500


OTHERS = (
    b"",
    b"{}",
    b"[]",
    b"null",
    b"\xff\xfe",
    b"[" * 100_000,
    b'{"format": 1}',
    b'{"format": NaN}',
    b"PK\x03\x04",
)


@pytest.mark.parametrize("text", OTHERS)
def test_what_is_no_certificate_is_refused_in_a_line(tmp_path, text):
    """Empty, nested, of another kind."""
    (tmp_path / "c.json").write_bytes(text)
    with pytest.raises(SchemaError) as error:
        read_certificate(tmp_path / "c.json")
    assert "\n" not in str(error.value)


def test_a_file_of_a_newer_version_is_told(tmp_path):
    """It is not damaged."""
    (tmp_path / "c.json").write_bytes(seal({**certificate_of().to_json(), "format": 2}))
    with pytest.raises(NewerFormat, match="has format 2, this version reads up to 1"):
        read_certificate(tmp_path / "c.json")


@given(place=st.integers(0, 10**9), bit=st.integers(0, 7))
def test_a_flipped_bit_is_found(tmp_path_factory, place, bit):
    """Wherever it is."""
    path = tmp_path_factory.mktemp("c") / "c.json"
    text = bytearray(seal(certificate_of().to_json(), is_flat=True))
    text[place % len(text)] ^= 1 << bit
    path.write_bytes(bytes(text))
    with pytest.raises(SchemaError):
        read_certificate(path)


def test_a_pipe_is_not_waited_for(tmp_path):
    """It is no regular file."""
    os.mkfifo(tmp_path / "c.json")
    with pytest.raises(SchemaError, match="regular"):
        read_certificate(tmp_path / "c.json")


KILLED = """
import os, sys
from pathlib import Path
from harness.files import bounded
bounded.sync = lambda path: os._exit(9)
from harness_plugins.audit.search.certificate import write_certificate
from tests.plugins.audit.search.certified import certificate_of
write_certificate(certificate_of(), Path(sys.argv[1]))
"""


def test_a_process_that_is_killed_leaves_nothing_half(tmp_path):
    """The earlier file is still there, whole."""
    path = tmp_path / "c.json"
    write_certificate(certificate_of(place=place_of("before")), path)
    assert subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False).returncode == 9
    assert read_certificate(path).place.reward.label == "before"
