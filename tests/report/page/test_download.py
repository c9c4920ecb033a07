"""Files inside a page."""

import base64
import gzip

from harness.report.page.html import pack


def test_file_comes_back():
    """As it was."""
    packed = pack("a.csv", "text/csv", "Ω₁,1\n")
    assert gzip.decompress(base64.b64decode(packed.content)).decode() == "Ω₁,1\n"


def test_same_text_gives_the_same_page():
    """At any time of day."""
    assert pack("a", "b", "c") == pack("a", "b", "c")
    assert base64.b64decode(pack("a", "b", "c").content)[4:8] == b"\0\0\0\0"
