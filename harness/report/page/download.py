"""Files inside a page. A click saves them, without any server."""

import base64
import gzip
from typing import NamedTuple


class Download(NamedTuple):
    """A file inside a page."""

    name: str
    kind: str
    """Its media type."""
    content: str
    """The content, compressed by gzip, as base64."""


def pack(name: str, kind: str, text: str) -> Download:
    """A file inside a page. The same text gives the same bytes, because no time of day is in them."""
    return Download(name, kind, base64.b64encode(gzip.compress(text.encode(), mtime=0)).decode())
