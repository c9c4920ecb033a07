"""The XML of a URDF: what counts as a word of it, and how much of it there may be."""

import time
from xml.etree import ElementTree

import pytest

from harness.errors import UsageError
from harness.robot.urdf import read_xml
from tests.refusals import refused

LINK = '<link name="a"/>'


@pytest.mark.parametrize(
    "text",
    [
        f"<robot>{LINK}</robot>",
        f'<?xml version="1.0"?>\n<robot xmlns:x="http://x">{LINK}</robot>',
        f'\ufeff<?xml version="1.0" encoding="utf-16"?><robot>{LINK}</robot>',
        f'<!-- a --><robot xmlns:x="http://x">{LINK}<x:a b="c"/></robot>',
        f'<robot xml:lang="en">{LINK}</robot>',
    ],
)
def test_text_that_every_parser_reads_stays_as_it_is(text):
    """To the last blank."""
    read = read_xml(text)
    assert read.text is text
    assert [(part.tag, part.attrib) for part in read.robot] == [("link", {"name": "a"})]
    assert read.robot.attrib == {}


def test_other_text_is_written_again(subtests):
    """Without the names that a parser with namespaces would stop at."""
    for text in [
        f'<robot xmlns="http://x">{LINK}</robot>',
        f"<robot><x:a/>{LINK}<x:b><link/></x:b></robot>",
        f'<robot x:a="b">{LINK}</robot>',
        f'<robot xmlns:x="">{LINK}</robot>',
        f"<robot>{LINK}<a: :b='c'/></robot>",
        f'\n<?xml version="1.0"?><robot>{LINK}</robot>',
        f'<!-- <?xml ?> --> <!--->--><?xml version="1.0"\n?><robot>{LINK}</robot>',
    ]:
        with subtests.test(text=text):
            read = read_xml(text)
            assert read.text == f"<robot>{LINK.replace('/', ' /')}</robot>"
            assert ElementTree.tostring(ElementTree.XML(read.text)) == ElementTree.tostring(read.robot)


def test_an_error_names_the_line_of_the_file():
    """Also where a declaration was left out before it."""
    with refused("mismatched tag: line 4"):
        read_xml('\n<?xml\nversion="1.0"?>\n<robot></link>')


@pytest.mark.parametrize("text", ["<!---->" * 400_000, " " * 4_000_000, "<!-- <?xml" * 400_000, "<?xml " * 600_000])
def test_what_stands_before_the_declaration_takes_no_time(text):
    """However much it is."""
    begin = time.perf_counter()
    with pytest.raises(UsageError):
        read_xml(text)
    assert time.perf_counter() - begin < 2.0


def test_a_declaration_inside_is_refused():
    """ROS's parser refuses it too."""
    with refused("not well-formed"):
        read_xml(f'<robot><?xml version="1.0"?>{LINK}</robot>')
