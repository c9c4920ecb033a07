"""Types a line of ``harness``, and reads the answer as a user does: what it says, and what it tells to type next."""

import io
import json
import re
import shlex
from collections.abc import Mapping
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import NamedTuple

from harness.cli import main

ENDS = ("in its last fifth", "in evaluations", "deterministic")
REFUSED, NO_REWARDS, INTERIM = "refused", "one reward", "interim"


class Said(NamedTuple):
    """What a line answered."""

    line: tuple[str, ...]
    word: str
    """The headline of each proposed reward; ``eta`` of steps; ``refused`` with a sentence."""
    shares: tuple[float, ...] = ()
    """Success in percent at the end, the baseline's first; fewer where the end of some is not known."""
    trainings: tuple[int, ...] = ()
    """How many there are of each reward."""
    text: str = ""
    """All that it says."""
    p: float | None = None


def say(line):
    """The answer to a line, which stands behind ``harness``."""
    line = tuple(line)
    out, err = io.StringIO(), io.StringIO()
    with redirect_stdout(out), redirect_stderr(err):
        try:
            main([*line, "--json"])
            status = 0
        except SystemExit as stopped:
            status = stopped.code
    if status and not out.getvalue():
        told = " ".join(err.getvalue().split())
        assert (status, out.getvalue(), "harness: " in told) == (2, "", True), (line, status, told)
        return Said(line, REFUSED, text=told[told.index("harness: ") :])
    data = json.loads(out.getvalue())
    text = f"{err.getvalue()} {' '.join(data.get('notes', []))}"
    if "dataset" in data:
        (found,) = data["rewards"]
        success = found["success"]
        shares = () if success["value"] is None else (100 * success["value"],)
        return Said(line, success["answer"].lower(), shares, text=f"{text} {success['reason']}")
    if "combinations" not in data:
        is_interim = data.get("verdict", [])[:1] and data["verdict"][0].startswith("Interim")
        return Said(line, INTERIM if is_interim else "eta", text=text)
    shares, words, p = [], {}, None
    for found in data["combinations"]:
        words[found["headline"]["answer"]] = None
        text += f" {found['headline']['behaviour']} {found['headline']['number']}"
        p = found["test"]["p"]
        ends = (it for it in found["behaviour"] if it["name"].startswith("success") and it["manner"] in ENDS)
        end = next(ends, None)
        if end is not None and end["proposed"] is not None and end["baseline"] is not None:
            shares += [100 * end["proposed"]] if shares else [100 * end["baseline"], 100 * end["proposed"]]
    taught = [it["reward"] for it in data["cells"] if it["status"] != "skipped"]
    counts = tuple(taught.count(name) for name in sorted(set(taught)))
    return Said(line, " | ".join(words) or NO_REWARDS, tuple(shares), counts, text, p)


FLAG = re.compile(
    r"(--(?:sort|as|leave-out|measure|labels|per-step|ends|baseline|success(?:-above|-when)?)) ('[^']*'|\S+)"
)
COMMAND = re.compile(r"(?<![\w-])harness (?:eta|report|audit) ")
QUOTED = ("--sort", "--leave-out")
"""Their values are paths, or stand in quotes; else a sentence only speaks of the flag."""
BETWEEN = re.compile(" (and )?")


def remedies(text):
    """What a text tells to type: flags to add to the line, those that stand together as one, and whole lines."""
    found, last = [], 0
    for match in FLAG.finditer(text):
        flag, value = match[1], match[2].strip("'") if match[2][0] == "'" else match[2].rstrip(".,;:)")
        is_path = "/" in value or match[2][0] == "'"
        is_spoken = not is_path if flag in QUOTED else value in ("says", "reads", "tells", "names", "takes")
        is_behind_command = COMMAND.search(text, max(0, match.start() - 120), match.start())
        if is_spoken or is_behind_command:
            continue
        if found and BETWEEN.fullmatch(text[last : match.start()]):
            found[-1] = (*found[-1], flag, value)
        else:
            found.append((flag, value))
        last = match.end() if match[2][0] == "'" else match.start(2) + len(value)
    for match in COMMAND.finditer(text):
        typed, flag = [text[match.start() : match.end()].split()[1]], ""
        for word in _words(text[match.end() :]):
            bare = word.rstrip(".,;:)")
            if not (bare.startswith("--") or flag or Path(bare.rpartition(":")[2]).exists()):
                break
            typed, flag = [*typed, bare], bare if bare.startswith("--") else ""
            if bare != word:
                break
        if len(typed) > 1:
            found.append(tuple(typed))
    return list(dict.fromkeys(found))


def _words(text):
    for match in re.finditer(r"'[^']*'|\S+", text):
        yield match[0].strip("'")


def typed(line, remedy, supplied: Mapping[str, str]):
    """The line that a user types who follows a remedy, with words in capitals replaced by what they know.

    Raises:
        KeyError: A word in capitals stands in it of which nobody says what it is.
    """

    def replaced(word):
        by_name = re.compile(r"(?<=[\w]=)N\b|(?<![\w{.'/-])(?:[A-Z]+)(?![\w}.'/-])")
        return by_name.sub(lambda it: _value(word, it, supplied), word)

    if not remedy[0].startswith("--"):
        return tuple(map(replaced, remedy))
    line = list(line)
    for flag, value in zip(remedy[::2], map(replaced, remedy[1::2]), strict=True):
        if flag in line and flag != "--leave-out":
            place = line.index(flag) + 1
            line[place] = _joined(line[place], value)
        else:
            line += [flag, value]
    return tuple(line)


def answered(line, knows):
    """What a line says in the end to one who answers what it asks of lengths of episodes."""
    said = say(line)
    for _ in range(2):
        asked = [it for it in remedies(said.text) if "episode=N" in " ".join(it)] if said.word == REFUSED else []
        if not asked:
            break
        said = say(typed(said.line, asked[0], knows))
    return said


def _value(word, match, supplied):
    before = re.search(r"([\w-]+)=$", word[: match.start()])
    return supplied[f"{before[1]}=N"] if before and f"{before[1]}=N" in supplied else supplied[match[0]]


def _joined(before, value):
    """Settings of one format are said together."""
    name, _, settings = before.partition(":")
    other, _, more = value.partition(":")
    return f"{value},{settings}" if name == other and settings and more not in settings else value


def shown(line):
    """The line as one types it."""
    return shlex.join(["harness", *line])
