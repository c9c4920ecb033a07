"""What a file is by its first bytes, and what reads it: many that are not what a reader expects are something known."""

import re
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

HEAD = 4096
"""Bytes of a file's beginning that tell what it is."""
MOST_KEYS = 32
"""Names at the top of an HDF5 file that are looked at."""


class FileKind(NamedTuple):
    """A kind of file."""

    name: str
    """With its article, ``a pickle``."""
    rest: str = ""
    """What to know about it, or what to do with it; begins with a letter."""
    endings: tuple[str, ...] = ()
    """How the name of such a file ends: of one that is called so nobody needs to be told."""

    @property
    def sentence(self) -> str:
        """Its name, and what to do."""
        return f"{self.name}: {self.rest}" if self.rest else self.name


POINTER = "the file itself was not fetched"
EXPORT = "export its numbers as CSV"
HDF5 = FileKind("an HDF5 file", EXPORT, (".h5", ".hdf5"))
ZIP = FileKind("a ZIP archive", "unpack it", (".zip",))
_BEGINNINGS: tuple[tuple[bytes, FileKind], ...] = (
    (b"version https://git-lfs.github.com/spec/", FileKind("a Git LFS pointer", f"{POINTER}: type git lfs pull")),
    (b"/annex/objects/", FileKind("a git-annex pointer", f"{POINTER}: type git annex get")),
    (b"\x89HDF\r\n\x1a\n", HDF5),
    (b"PAR1", FileKind("a Parquet file", EXPORT, (".parquet", ".pq"))),
    (b"ARROW1", FileKind("an Arrow file", EXPORT, (".arrow", ".feather", ".ipc"))),
    (b"FEA1", FileKind("a Feather file", EXPORT, (".feather",))),
    (b"\x93NUMPY", FileKind("a NumPy array", "write it with numpy.savetxt", (".npy",))),
    (b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1", FileKind("an Excel file", "save its sheet as CSV", (".xls",))),
    (b"\x1f\x8b", FileKind("compressed by gzip", "unpack it with gunzip", (".gz", ".tgz"))),
    (b"BZh", FileKind("compressed by bzip2", "unpack it with bunzip2", (".bz2",))),
    (b"\xfd7zXZ\x00", FileKind("compressed by xz", "unpack it with unxz", (".xz",))),
    (b"\x28\xb5\x2f\xfd", FileKind("compressed by Zstandard", "unpack it with unzstd", (".zst",))),
    (b"SQLite format 3\x00", FileKind("an SQLite database", EXPORT, (".db", ".sqlite", ".sqlite3"))),
    (b"MATLAB 5.0 MAT-file", FileKind("a MATLAB file", EXPORT, (".mat",))),
    (b"%PDF-", FileKind("a PDF file", "", (".pdf",))),
    (b"\x7fELF", FileKind("a program", "")),
    (b"#ROSBAG", FileKind("a ROS bag", EXPORT, (".bag",))),
    (b"\x89MCAP0\r\n", FileKind("an MCAP recording", EXPORT, (".mcap",))),
    (b":W&B", FileKind("a run of Weights & Biases", "export its charts as CSV", (".wandb",))),
)
_SIGNS: tuple[tuple[re.Pattern[bytes], FileKind], ...] = (
    (
        re.compile(rb"(?s).{12,52}brain\.Event:"),  # records behind lengths and checksums; the first says the version
        FileKind("a TensorBoard event file", "its values are means over episodes; an index needs the reward of each "
                 "step"),
    ),
    (
        re.compile(rb"\x80[\x02-\x05]"),
        FileKind("a pickle", f"to read it would run its code; {EXPORT} where it was made", (".pkl", ".pickle", ".p")),
    ),
    (
        re.compile(rb"(?i)[\xef\xbb\xbf \t\r\n]*(<!doctype html|<html)"),
        FileKind("a web page", "download the file itself, which is often called raw", (".html", ".htm")),
    ),
    (re.compile(rb"\xff\xfe|\xfe\xff"), FileKind("text in UTF-16", "save it as UTF-8")),
)  # fmt: skip
"""Files by how they begin."""
_ARCHIVES: tuple[tuple[re.Pattern[bytes], FileKind], ...] = (
    (
        re.compile(rb"\[Content_Types\]\.xml|_rels/|xl/|docProps/"),
        FileKind("an Excel file", "save its sheet as CSV", (".xlsx", ".xlsm", ".docx", ".pptx")),
    ),
    (
        re.compile(rb"[^/]*\.npy"),
        FileKind("a NumPy archive (.npz)", "write its arrays with numpy.savetxt", (".npz",)),
    ),
    (
        re.compile(rb"data$|pytorch_variables|policy\.|[^/]*/data\.pkl"),
        FileKind("a trained model", "nothing in it was recorded while it trained", (".zip", ".pt", ".pth")),
    ),
)
"""ZIP archives by the name of their first member."""
_LAYOUTS: tuple[tuple[str, FileKind], ...] = (
    ("terminals", FileKind("a D4RL data set in HDF5", "judge its rewards: harness audit d4rl:FILE")),
    (
        "data/demo_",
        FileKind("a robomimic data set in HDF5", "judge its rewards: harness audit robomimic:FILE"),
    ),
    ("episode_", FileKind("a Minari data set in HDF5", "name the set itself: harness audit minari:NAME")),
)
"""HDF5 files by how a name in them begins."""


def kind_of(head: bytes, path: Path | None = None) -> FileKind | None:
    """What a file is that begins so; None for text, and for whatever is not known.

    Args:
        head: Its first `HEAD` bytes.
        path: Where it lies, if it may be opened to see more: a regular file.
    """
    kind = next((kind for beginning, kind in _BEGINNINGS if head.startswith(beginning)), None)
    if kind is HDF5:
        return _hdf5(path) if path is not None else kind
    if head.startswith((b"PK\x03\x04", b"PK\x05\x06")):
        first = head[30 : 30 + int.from_bytes(head[26:28], "little")]
        return next((kind for pattern, kind in _ARCHIVES if pattern.match(first)), ZIP)
    return kind or next((kind for pattern, kind in _SIGNS if pattern.match(head)), None)


def _hdf5(path: Path) -> FileKind:
    """Which data set an HDF5 file is, where h5py is installed."""
    names = names_in_hdf5(path)
    return next((kind for begin, kind in _LAYOUTS if any(name.startswith(begin) for name in names)), HDF5)


def names_in_hdf5(path: Path) -> list[str]:
    """The first names at the top of an HDF5 file and in its group ``data``; none where it cannot be opened.

    Names are looked up, no data are read.
    """
    names: list[str] = []
    with suppress(Exception):  # whatever a damaged file raises, or no h5py: then it is an HDF5 file
        import h5py

        with h5py.File(path, "r", locking=False) as file:
            names = [name for name, _ in zip(file, range(MOST_KEYS), strict=False)]
            if isinstance(file.get("data", getlink=True), h5py.HardLink):
                names += [f"data/{name}" for name, _ in zip(file["data"], range(MOST_KEYS), strict=False)]
    return names
