"""Files are written, and read by a format that recognises them."""

from harness.log.open_log import formats_of
from tests.registered import REGISTRY

FORMATS = formats_of(REGISTRY)


class Reader:
    """Reads files of one format."""

    def __init__(self, name: str, file: str = "0.csv") -> None:
        """By the names of the format and of the files that are written."""
        self.make, self.file = type(FORMATS[name]), file

    def is_recognised(self, path):
        """Whether the format says that it is its own."""
        return self.make().recognises(path, path.read_bytes()[:4096] if path.is_file() else b"")

    def logs(self, path, **settings):
        """Those of a file that the format recognises."""
        assert self.is_recognised(path)
        return list(self.make(**settings).read(path))

    def __call__(self, path, **settings):
        """The one log of it."""
        [log] = self.logs(path, **settings)
        return log

    def written(self, folder, text, name=""):
        """A file with this text."""
        path = folder / (name or self.file)
        path.write_bytes(text.encode())
        return path
