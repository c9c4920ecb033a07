"""What a file is by its first bytes: each written by the library that others write it with, or by its format's page."""

import io
import pickle
import zipfile

import numpy as np
import pyarrow as pa
import pyarrow.feather
import pyarrow.parquet as pq
import pytest

from harness.errors import SchemaError
from harness.files import reading
from harness.files.bounded import kind_at


def write_npz(path):
    """As stable-baselines3's EvalCallback leaves evaluations.npz."""
    with path.open("wb") as file:
        np.savez(file, timesteps=np.arange(3), results=np.zeros((3, 5)), ep_lengths=np.ones((3, 5)))


def write_event_file(path):
    """The first record of TensorBoard's: length, checksum, an Event with wall_time and file_version, checksum."""
    event = b"\x09" + b"\0" * 8 + b"\x1a\x0dbrain.Event:2"
    path.write_bytes(len(event).to_bytes(8, "little") + b"abcd" + event + b"efgh")


def write_hdf5(*names):
    """A file with data sets of these names, as h5py writes them."""

    def write(path):
        with pytest.importorskip("h5py").File(path, "w") as file:
            for name in names:
                file[name] = np.zeros(3)

    return write


def write_zip(*names):
    """An archive with these members."""

    def write(path):
        with zipfile.ZipFile(path, "w") as file:
            for name in names:
                file.writestr(name, "x")

    return write


D4RL = ("actions", "infos/qpos", "infos/qvel", "metadata/algorithm", "next_observations", "observations", "rewards")
KINDS = {
    "a Git LFS pointer": lambda path: path.write_text(
        f"version https://git-lfs.github.com/spec/v1\noid sha256:{'0' * 64}\nsize 12345\n"
    ),
    "a git-annex pointer": lambda path: path.write_text("/annex/objects/SHA256E-s5--0.csv\n"),
    "a TensorBoard event file": write_event_file,
    "a D4RL data set in HDF5": write_hdf5(*D4RL, "terminals", "timeouts"),
    "a robomimic data set in HDF5": write_hdf5("data/demo_0/actions", "data/demo_0/rewards", "mask/train"),
    "a Minari data set in HDF5": write_hdf5("episode_0/actions", "episode_0/rewards"),
    "an HDF5 file": write_hdf5("x"),
    "a NumPy archive (.npz)": write_npz,
    "a NumPy array": lambda path: path.write_bytes(_npy()),
    "a pickle": lambda path: path.write_bytes(pickle.dumps({"reward": [1.0]})),
    "an Excel file": write_zip("[Content_Types].xml", "_rels/.rels", "xl/workbook.xml"),
    "a trained model": write_zip("data", "pytorch_variables.pth", "policy.pth"),
    "a ZIP archive": write_zip("runs/0.csv"),
    "a Parquet file": lambda path: pq.write_table(pa.table({"a": [1]}), path),
    "an Arrow file": lambda path: pyarrow.feather.write_feather(pa.table({"a": [1]}), str(path)),
    "compressed by gzip": lambda path: path.write_bytes(b"\x1f\x8b\x08\0"),
    "an SQLite database": lambda path: path.write_bytes(b"SQLite format 3\0"),
    "a web page": lambda path: path.write_text("\n<!DOCTYPE html>\n<html></html>"),
    "text in UTF-16": lambda path: path.write_text("reward\n1\n", encoding="utf-16"),
}


def _npy():
    file = io.BytesIO()
    np.save(file, np.zeros(3))
    return file.getvalue()


def test_a_file_is_called_by_its_name(tmp_path_factory, subtests):
    """Whatever it is called, and with what to do."""
    for name, write in KINDS.items():
        with subtests.test(name=name):
            tmp_path = tmp_path_factory.mktemp("case")
            write(tmp_path / "it.csv")
            kind = kind_at(tmp_path / "it.csv")
            assert kind is not None
            assert kind.name == name
            assert kind.rest


def test_text_is_no_kind(tmp_path_factory, subtests):
    """A reader of text says itself what is wrong with it."""
    for text in ["reward\n1\n", "\ufeffreward\n", "#{}\nr,l,t\n", "", "version,reward\n", "{}"]:
        with subtests.test(text=text):
            tmp_path = tmp_path_factory.mktemp("case")
            (tmp_path / "it.csv").write_text(text)
            assert kind_at(tmp_path / "it.csv") is None


def test_what_is_not_there_is_no_kind(tmp_path):
    """Nor is a folder."""
    assert kind_at(tmp_path / "gone") is None
    assert kind_at(tmp_path) is None


def test_an_hdf5_file_that_breaks_off_is_one(tmp_path):
    """Whatever h5py raises."""
    (tmp_path / "it").write_bytes(b"\x89HDF\r\n\x1a\n" + b"\xff" * 100)
    kind = kind_at(tmp_path / "it")
    assert kind is not None
    assert kind.name == "an HDF5 file"


def test_every_reader_names_what_it_got(tmp_path):
    """A pointer in the place of a Parquet file, where pyarrow raises: the line says what to type."""
    path = tmp_path / "trace.parquet"
    KINDS["a Git LFS pointer"](path)
    with (
        pytest.raises(SchemaError, match=r"no readable trace: it is a Git LFS pointer: .*git lfs pull"),
        reading(path, "trace"),
    ):
        pq.read_table(path)


def test_a_reader_of_a_kind_says_what_is_wrong_with_it(tmp_path):
    """A Parquet file that breaks off is no news as a Parquet file."""
    path = tmp_path / "trace.parquet"
    pq.write_table(pa.table({"a": [1]}), path)
    path.write_bytes(path.read_bytes()[:20])
    with pytest.raises(SchemaError, match=r"no readable trace: Arrow"), reading(path, "trace"):
        pq.read_table(path)
