"""Files: read within bounds, written whole or not at all, named so that a name stays in its folder.

And those that say whether they are what was written: sealed, keyed, listed.
"""

import errno
import hashlib
import hmac
import json
import math
import os
import re
import secrets
import stat
import sys
import unicodedata
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, BinaryIO, NamedTuple

from harness.errors import HarnessError, NewerFormat, SchemaError, one_line

TEXT_BYTES = 16 * 2**20
"""Most that is read of a file that people or programs write as text, unless a reader says otherwise."""

# What a file is by its first bytes: many that are not what a reader expects are something known

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
        names = [] if path is None else names_in_hdf5(path)  # which data set it is, where h5py is installed
        return next((kind for begin, kind in _LAYOUTS if any(name.startswith(begin) for name in names)), HDF5)
    if head.startswith((b"PK\x03\x04", b"PK\x05\x06")):
        first = head[30 : 30 + int.from_bytes(head[26:28], "little")]
        return next((kind for pattern, kind in _ARCHIVES if pattern.match(first)), ZIP)
    return kind or next((kind for pattern, kind in _SIGNS if pattern.match(head)), None)


def names_in_hdf5(path: Path) -> list[str]:
    """The first names at the top of an HDF5 file and in its group ``data``; none where it cannot be opened.

    Names are looked up, no data are read. There are at most `MOST_KEYS` of each place; the latter begin with ``data/``.
    """
    names: list[str] = []
    with suppress(Exception):  # whatever a damaged file raises, or no h5py: then it is an HDF5 file
        import h5py

        with h5py.File(path, "r", locking=False) as file:
            names = [name for name, _ in zip(file, range(MOST_KEYS), strict=False)]
            if isinstance(file.get("data", getlink=True), h5py.HardLink):
                names += [f"data/{name}" for name, _ in zip(file["data"], range(MOST_KEYS), strict=False)]
    return names


# Reading


@contextmanager
def open_regular(path: Path, most: int) -> Iterator[BinaryIO]:
    """A regular file, open for reading: no pipe that hangs, no device that never ends. A link to one is followed.

    Args:
        path: The file.
        most: Bytes that it may have.

    Raises:
        OSError: It is not there, cannot be read, is no regular file or is too large.
    """
    # Without O_NONBLOCK a pipe that nobody writes to would hold us here.
    number = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
    with os.fdopen(number, "rb") as file:
        found = os.fstat(number)
        if not stat.S_ISREG(found.st_mode):
            raise OSError(errno.EINVAL, "it is no regular file", str(path))
        if found.st_size > most:
            raise OSError(errno.EFBIG, f"it has {found.st_size:,} bytes, {most:,} are allowed", str(path))
        yield file


def require_regular(path: Path, most: int) -> None:
    """See whether a library may open a file by its name; see `open_regular`."""
    with open_regular(path, most):
        pass


def kind_at(path: Path) -> FileKind | None:
    """What a file is by its first bytes; None for text, for what is not known, and where it cannot be read."""
    try:
        with open_regular(path, sys.maxsize) as file:
            head = file.read(HEAD)
    except OSError:
        return None
    return kind_of(head, path)


def read_bytes(path: Path, most: int = TEXT_BYTES) -> bytes:
    """All of a regular file; see `open_regular`.

    Args:
        path: The file.
        most: Bytes that it may have.

    Raises:
        OSError: It is not there, cannot be read, is no regular file or is too large.
    """
    with open_regular(path, most) as file:
        return file.read()


def read_text(path: Path, most: int = TEXT_BYTES) -> str:
    """All of a regular file in UTF-8; see `open_regular`.

    Raises:
        UnicodeDecodeError: It is not in UTF-8.
    """
    return read_bytes(path, most).decode("utf-8")


def read_json(path: Path, most: int = TEXT_BYTES) -> Any:
    """The content of a JSON file; see `open_regular`.

    Raises:
        ValueError: It is no JSON, is nested too deeply, or holds NaN or an infinity, which JSON does not have.
    """
    return parse_json(read_bytes(path, most))


def parse_json(text: bytes) -> Any:
    """What a JSON text in UTF-8 says.

    Raises:
        ValueError: As `read_json`.
    """
    try:
        return json.loads(text.decode("utf-8"), parse_constant=_refuse, parse_float=_finite)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def _finite(number: str) -> float:
    value = float(number)
    if not math.isfinite(value):
        raise ValueError(f"it holds {number}, which is beyond all numbers")
    return value


def _refuse(constant: str) -> Any:
    raise ValueError(f"it holds {constant}, which is no JSON")


@contextmanager
def reading(path: Path, noun: str, kind: type[HarnessError] = SchemaError) -> Iterator[None]:
    """Whatever a reader lets through becomes one line that names the file, and what it is if that is something else.

    Args:
        path: What is read.
        noun: What it should be, ``trace``.
        kind: What is raised; `UsageError` where a user named the file.

    Raises:
        SchemaError: The block raised something else than a `HarnessError`; or `kind`, where it is another.
    """
    try:
        yield
    except HarnessError:
        raise
    except Exception as error:  # readers of other people's bytes raise anything
        found = kind_at(path)
        is_other = found is not None and noun not in found.name and not path.name.lower().endswith(found.endings)
        reason = f"it is {found.sentence}" if found is not None and is_other else one_line(error)
        if not path.exists():
            reason = "there is no such file"
        elif path.is_file() and not path.stat().st_size:
            reason = "it is empty"
        raise kind(f"{path} is no readable {noun}: {reason}") from error


def digest_of(path: Path) -> str:
    """SHA-256 of a file, in hexadecimal."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


PARTIAL = ".partial"
"""The end of the name of a file that is not complete; such a name begins with a dot."""


@contextmanager
def whole_file(path: Path) -> Iterator[Path]:
    """A place beside `path` to write to; what is written there takes the place of `path` when the block ends.

    A reader finds the old file or the new one, whole. When an exception passes, the old one stays. A link at `path` is
    replaced, not followed.

    Raises:
        OSError: The file cannot take its place.
    """
    with whole_files(path.parent, [path.name]) as (partial,):
        yield partial


@contextmanager
def whole_files(folder: Path, names: Sequence[str], is_lasting: bool = True) -> Iterator[list[Path]]:
    """The same for several files of one folder. They take their places in this order, and all are written by then.

    Args:
        folder: Where they belong.
        names: Of the files.
        is_lasting: They also survive a machine that stops. That takes the disk some milliseconds for each file.

    Raises:
        OSError: One of them cannot take its place; those before it have.
    """
    partials = [folder / f".{name}.{os.getpid()}{PARTIAL}" for name in names]
    for partial in partials:
        partial.unlink(missing_ok=True)  # of a killed process with this number, or a link that somebody laid there
    try:
        yield partials
        if is_lasting:
            for partial in partials:
                sync(partial)  # else a machine that stops could leave the new name on an empty file
        for partial, name in zip(partials, names, strict=True):
            os.replace(partial, folder / name)
        if is_lasting:
            sync(folder)
    finally:
        for partial in partials:
            with suppress(OSError):  # gone if it took its place, never there if it could not be written
                partial.unlink()


def write_whole(path: Path, content: str | bytes) -> None:
    """Write a file, text as UTF-8; see `whole_file`."""
    with whole_file(path) as partial:
        partial.write_bytes(content.encode() if isinstance(content, str) else content)


def is_partial(path: Path) -> bool:
    """Whether a process that was killed left it half written."""
    return path.name.startswith(".") and path.name.endswith(PARTIAL)


def files_in(folder: Path) -> list[Path]:
    """All files in a folder and in the folders in it, in order. Links to folders are not followed."""
    return sorted(Path(place) / name for place, _, names in os.walk(folder) for name in names)


def sync(path: Path) -> None:
    """Have the system write a file, or the names in a folder, to the disk.

    Raises:
        OSError: It cannot.
    """
    if path.is_dir() and os.name == "nt":
        return  # Windows opens no folder
    number = os.open(path, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


LONGEST = 255
"""The most bytes of the name of a file, on most systems."""


def is_plain(name: str) -> bool:
    r"""Whether a name is that of a file or folder in the folder that names it, and in no other place.

    ``..``, ``.``, ``a/b``, ``a\b``, ``C:a``, and names that are empty, too long, or hold a character that no text has,
    are not.
    """
    if name in ("", ".", "..") or any(char in name for char in "/\\:"):
        return False
    if any(unicodedata.category(char) in ("Cc", "Cs") for char in name):
        return False
    return len(name.encode()) <= LONGEST


def is_inside(path: str) -> bool:
    """Whether a path, its parts between slashes, leads to a file in the folder that names it, or below."""
    return all(map(is_plain, path.split("/")))


def twins(paths: Iterable[str]) -> list[str]:
    """The paths that some systems take for another one of the list: its case or its accents are written otherwise."""
    known: dict[str, str] = {}
    return [path for path in paths if known.setdefault(_on_any_system(path), path) != path]


def _on_any_system(path: str) -> str:
    return unicodedata.normalize("NFC", unicodedata.normalize("NFC", path).casefold())


KEY = "digest"


_LAST = re.compile(rb'"digest": "([0-9a-f]{64})"\n}\n\Z')


_EMPTY = b'"digest": ""\n}\n'


_NUMBERS = re.compile(r"\[\n\s+([^][{}\"]+?)\n\s+\]")
"""A list without texts, lists and objects in it; no text in JSON holds the end of a line."""


def seal(content: Mapping[str, Any], is_flat: bool = False) -> bytes:
    """The JSON text of `content`, whose last key is the SHA-256 of the text with that key empty.

    Args:
        content: Plain data.
        is_flat: Write a list of numbers on one line.
    """
    indented = json.dumps({**content, KEY: ""}, indent=1, allow_nan=False)
    flat = _NUMBERS.sub(lambda found: f"[{' '.join(found[1].split())}]", indented) if is_flat else indented
    text = f"{flat}\n".encode()
    return text[: -len(_EMPTY)] + f'"{KEY}": "{hashlib.sha256(text).hexdigest()}"\n}}\n'.encode()


def unseal(text: bytes) -> dict[str, Any]:
    """The content that `seal` wrote, the digest left out.

    Raises:
        ValueError: It is not what was written.
    """
    _require_whole(text)
    content: dict[str, Any] = parse_json(text)
    del content[KEY]
    return content


def _require_whole(text: bytes) -> None:
    found = _LAST.search(text)
    if found is None:
        raise ValueError("its digest is missing")
    if _digest(text[: found.start()] + _EMPTY) != found[1]:
        raise ValueError("it is not what was written: its digest differs")


def read_sealed(path: Path, noun: str, newest: int, since: int, most: int = TEXT_BYTES) -> dict[str, Any]:
    """The object in a JSON file with the key ``format``; sealed, if its format is `since` or newer.

    Args:
        path: The file.
        noun: What it should be, ``manifest``.
        newest: The newest format that can be read; a file without the key has format 1.
        since: The first format that is sealed.
        most: Bytes that it may have.

    Raises:
        SchemaError: It cannot be read, is no JSON object, or is not what was written.
        NewerFormat: A newer version wrote it.
    """
    with reading(path, noun):
        text = read_bytes(path, most)
        content = parse_json(text)
        if not isinstance(content, dict):
            raise ValueError("it holds no object")
        number = content.get("format", 1)
        if not isinstance(number, int):
            raise ValueError(f"its format is {number!r}")
        if number > newest:
            raise NewerFormat(f"{path} has format {number}, this version reads up to {newest}")
        if number >= since or KEY in content:
            _require_whole(text)
            del content[KEY]
        return content


STATE = "XDG_STATE_HOME"
"""The environment variable that names a folder for what programs remember; ``~/.local/state`` without it."""


def state_folder() -> Path:
    """The folder, which may not be there yet.

    Raises:
        RuntimeError: The user has no home folder.
    """
    state = Path(os.environ.get(STATE, ""))
    if not state.is_absolute():  # relative ones are to be ignored, says the standard
        state = Path.home() / ".local" / "state"
    return state / "fd100-harness"


def write_keyed(path: Path, key: str, content: bytes) -> None:
    """Write a file that `read_keyed` gives back under the same key alone, a line of text.

    It is not synced to the disk: `read_keyed` tells a file that a stopped machine left empty, and it is made again.

    Raises:
        OSError: It cannot be written.
    """
    with whole_files(path.parent, [path.name], is_lasting=False) as (partial,):
        partial.write_bytes(with_key(key, content))


def read_keyed(path: Path, key: str, most: int) -> bytes | None:
    """What was written under `key`.

    None where nothing can be read there, nothing of at most `most` bytes, or something that was not written whole under
    this key, by this user on this machine: the caller makes it again.
    """
    signature, _, signed = (_whole(path, most) or b"").partition(b"\n")
    own = f"{key}\n".encode()
    is_ours = hmac.compare_digest(signature, _sign(signed))
    return signed[len(own) :] if is_ours and signed.startswith(own) else None


def is_whole(path: Path, most: int) -> bool:
    """Whether a file is what was written, under whatever key and by whomever."""
    return _whole(path, most) is not None


def _whole(path: Path, most: int) -> bytes | None:
    """What stands behind the digest in a file; None where that is the digest of something else, or nothing is read."""
    try:
        told, _, rest = read_bytes(path, most).partition(b"\n")
    except OSError:
        return None
    return rest if told == _digest(rest) else None


def with_key(key: str, content: bytes) -> bytes:
    """The file: lines with the SHA-256 of all behind it, the signature of what follows, and the key; the content."""
    signed = f"{key}\n".encode() + content
    rest = _sign(signed) + b"\n" + signed
    return _digest(rest) + b"\n" + rest


def _sign(content: bytes) -> bytes:
    return hmac.digest(machine_key(), content, "sha256").hex().encode()


def _digest(content: bytes) -> bytes:
    return hashlib.sha256(content).hexdigest().encode()


SIZE = 32
"""Bytes of the key."""


def key_file() -> Path:
    """Where the key is."""
    return state_folder() / "key"


@lru_cache(maxsize=1)  # a report signs and compares thousands of files
def machine_key() -> bytes:
    """The key, made when it is asked for the first time. Where none can be kept, one that ends with this process."""
    try:
        path = key_file()
        return _read(path) or _make(path) or secrets.token_bytes(SIZE)
    except (OSError, RuntimeError):  # no home, or one that allows no writing
        return secrets.token_bytes(SIZE)


def _read(path: Path) -> bytes | None:
    """The key that is there; None if there is none, or one that others may know or have written."""
    try:
        number = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0))
    except OSError:
        return None
    with os.fdopen(number, "rb") as file:
        found = os.fstat(number)
        is_mine = not hasattr(os, "getuid") or (found.st_uid == os.getuid() and not found.st_mode & 0o077)
        content = file.read(SIZE + 1) if is_mine and stat.S_ISREG(found.st_mode) else b""
    return content if len(content) == SIZE else None


def _make(path: Path) -> bytes | None:
    """Make a key, unless another process is quicker; None if something else stands in its place."""
    path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    partial = path.with_name(f".key.{os.getpid()}.{secrets.token_hex(4)}")
    number = os.open(partial, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    try:
        with os.fdopen(number, "wb") as file:
            file.write(secrets.token_bytes(SIZE))
        with suppress(FileExistsError):  # another process was quicker: its key is read below
            os.link(partial, path)
    finally:
        partial.unlink()
    return _read(path)


SUMS = "SHA256SUMS"


FIRST_LINE = "# harness made these files from others"
"""It says whose list it is; ``sha256sum`` takes it for a comment."""


_LINE = re.compile(r"([0-9a-f]{64})  (.+)")


_EARLIER = re.compile(r"report\.html|results\.parquet|scores[\w.-]*")
"""The names in lists of version 0.1, which had no such line."""


def note_made(path: Path) -> None:
    """Write the digest of a file that was just made beside it, in place of an earlier one.

    Raises:
        OSError: It cannot be written.
    """
    if (told := _sums(path.parent)) is not None:
        there = {name: it for name, it in told.items() if (path.parent / name).is_file()}
        write_whole(path.parent / SUMS, _text_of({**there, path.name: digest_of(path)}))


@contextmanager
def making(path: Path) -> Iterator[None]:
    """Within this a file is made in place of an earlier one; then `note_made`.

    Killed at any moment, this leaves no digest of another file than the one that is there.

    Raises:
        OSError: The digests cannot be written.
    """
    told = read_sums(path.parent)
    if told.pop(path.name, None) is not None:
        write_whole(path.parent / SUMS, _text_of(told))
    yield
    note_made(path)


def forget_made(path: Path) -> None:
    """Take a file out of the list beside it, which is whole after that; an empty list is removed.

    Raises:
        OSError: It cannot be written.
    """
    told = _sums(path.parent)
    if told is None:
        return
    told.pop(path.name, None)
    if told:
        write_whole(path.parent / SUMS, _text_of(told))
    else:
        (path.parent / SUMS).unlink(missing_ok=True)


def read_sums(folder: Path) -> dict[str, str]:
    """The digests in a folder's ``SHA256SUMS``, by the name of a file there.

    Lines that name no file of the folder are left out, and so is a foreign list.
    """
    return _sums(folder) or {}


def changed_since_made(folder: Path) -> list[str]:
    """Names of the files in `folder` that are not what was made; ``SHA256SUMS`` too, if that is damaged itself."""
    sums, path = _sums(folder), folder / SUMS
    if sums is None:
        return []
    changed = [name for name, digest in sums.items() if not _is(folder / name, digest)]
    whole = [_text_of(sums), _text_of(sums).removeprefix(f"{FIRST_LINE}\n")]
    if path.exists() and not any(_is(path, hashlib.sha256(text.encode()).hexdigest()) for text in whole):
        changed.append(SUMS)
    return changed


def _sums(folder: Path) -> dict[str, str] | None:
    """See `read_sums`; None where somebody else wrote the list."""
    try:
        lines = read_text(folder / SUMS).splitlines()
    except (OSError, UnicodeDecodeError):
        lines = []  # not there, or damaged: what it told of can be made again
    told = {found[2]: found[1] for found in map(_LINE.fullmatch, lines) if found and is_plain(found[2])}
    return told if lines[:1] == [FIRST_LINE] or all(map(_EARLIER.fullmatch, told)) else None


def _text_of(sums: Mapping[str, str]) -> str:
    return f"{FIRST_LINE}\n" + "".join(f"{digest}  {name}\n" for name, digest in sorted(sums.items()))


def _is(path: Path, digest: str) -> bool:
    return path.is_file() and not path.is_symlink() and digest_of(path) == digest
