"""The pages that people read, their fenced blocks, and the commands in these."""

import re
import shlex
from typing import NamedTuple

from tests.project import ROOT

PAGES = [
    *(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "SECURITY.md")),
    *(
        path
        for folder in ("docs", "examples", "robots")
        for path in sorted((ROOT / folder).rglob("*.md"))
        if "generated" not in path.parts  # made from what is read here
    ),
]
FENCE = re.compile(r"^( *)(`{3,})([\w{}-]*)[^\n]*\n(.*?)^\1\2 *$", re.MULTILINE | re.DOTALL)
SHELL = {"", "text", "bash", "console", "sh"}
PROMPT = re.compile(r"^(?:\w*\$ +|time +)")
REMARK = re.compile(r"\s(?:#|\s).*$")
"""What the pages write behind a command: after a `#`, or after two blanks."""
QUOTED = re.compile(r"'[^']*'|\"[^\"]*\"")


class Block(NamedTuple):
    """A fenced block of a page."""

    page: str
    line: int
    language: str
    text: str

    @property
    def place(self):
        """Where it begins, as `docs/eta.md:4`."""
        return f"{self.page}:{self.line}"


class Command(NamedTuple):
    """A line that begins with `harness`."""

    place: str
    text: str

    @property
    def is_pattern(self):
        """Whether it is no command to type: it has brackets around what may be left out, or dots for what is."""
        return bool(re.search(r"\[--|\[:| \.\.\. |\.\.\.$|NAME|,\.\.\.", QUOTED.sub("", self.text)))

    @property
    def words(self):
        """Its words after `harness`."""
        return shlex.split(self.text)[1:]


def blocks():
    """All fenced blocks of all pages, in order."""
    for path in PAGES:
        yield from blocks_of(path.relative_to(ROOT).as_posix(), path.read_text())


def blocks_of(page, text):
    """The fenced blocks of a page."""
    for found in FENCE.finditer(text):
        indent, _, language, inside = found.groups()
        lines = [line.removeprefix(indent) for line in inside.splitlines(keepends=True)]
        yield Block(page, text.count("\n", 0, found.start()) + 2, language, "".join(lines))


def commands_of(block):
    """The commands of `harness` in a block that is for a shell."""
    if block.language not in SHELL:
        return
    for number, line in enumerate(re.sub(r" *\\\n *", " ", block.text).splitlines()):
        for part in re.split(r" && |; ", line):
            text = PROMPT.sub("", part.strip())
            if text.startswith("harness "):
                yield Command(f"{block.page}:{block.line + number}", _without_remark(text))


def _without_remark(text):
    """The command alone; what stands in quotes is left as it is."""
    hidden = QUOTED.sub(lambda found: "x" * len(found[0]), text)
    return text[: len(REMARK.sub("", hidden))].rstrip()
