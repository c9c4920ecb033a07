"""Text of strangers, fit to be shown."""

import re
import shlex
import shutil
import subprocess
import unicodedata
from pathlib import Path

import pytest
from hypothesis import given, strategies as st

import harness
from harness.errors import one_line
from harness.text import LONGEST_MESSAGE, command_text, file_stems, number, shortened, visible


def test_what_is_not_seen_is_written_out(subtests):
    """Control characters of both sets, turns of the direction, marks without width, separators of lines."""
    for text, shown in [
        ("\x1b[31mred", "\\x1b[31mred"),
        ("\x9b2J", "\\x9b2J"),
        ("a\u202eb", "a\\u202eb"),
        ("a\u200bb", "a\\u200bb"),
        ("a\u2028b", "a\\u2028b"),
        ("a\nb\tc", "a\\nb\\tc"),
        ("name\udc80", "name\\udc80"),
        ("\U000e0041", "\\U000e0041"),
    ]:
        with subtests.test(text=text):
            assert visible(text) == shown


@pytest.mark.parametrize("text", ["eta η_N · 3 × 10⁻³", "Grüße, 世界, مرحبا", "a\u00a0b", "🤖", "[/b] \\n"])
def test_ordinary_text_stays(text):
    """Letters of all languages, signs, blanks."""
    assert visible(text) == text


def test_a_line_break_can_be_kept():
    """A text of several lines stays one."""
    assert visible("a\n\x1bb", keep="\n") == "a\n\\x1bb"


@given(st.text(st.characters(exclude_categories=())))
def test_nothing_hidden_is_left(text):
    """Of any text; and to show what was shown changes nothing."""
    shown = visible(text)
    assert all(unicodedata.category(char)[0] != "C" and char not in "\u2028\u2029" for char in shown)
    assert visible(shown) == shown


def test_a_long_message_keeps_its_beginning_and_its_end():
    """The file that it names, and what to do."""
    message = shortened("run.csv: " + "x" * 13_000 + ". Export it again.")
    assert len(message) == LONGEST_MESSAGE
    assert message.startswith("run.csv: ")
    assert message.endswith("x. Export it again.")


def test_a_flag_to_type_is_kept_with_what_it_gets():
    """A long path is cut where it was given, and not where it is to be typed."""
    for length in range(10, 170):
        path = f"'/{'f' * length}'"
        shown = one_line(f"{path} was trained with prop {'and so on ' * 20}: leave it out, --leave-out {path}")
        assert len(shown) <= LONGEST_MESSAGE
        assert shown.endswith(f"--leave-out {path}")


def test_a_list_is_cut_between_its_names():
    """Each name that is shown is whole, whatever the place of the cut."""
    for length in range(1, 60):
        names = [f"{'n' * length}-{number}" for number in range(400)]
        shown = one_line(f"No reward 'x'. There is: {', '.join(names)}. Did you mean 'y'?")
        first, _, last = shown.removeprefix("No reward 'x'. There is: ").partition(" ... ")
        assert len(shown) <= LONGEST_MESSAGE
        assert set(first.rstrip(",").split(", ")) <= set(names)
        assert set(last.removesuffix(". Did you mean 'y'?").split(", ")) <= set(names)


def test_words_before_and_behind_a_cut_are_whole(subtests):
    """Also where the cut lies between two words."""
    for most in range(20, 40):
        with subtests.test(most=most):
            words = ["one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten"]
            before, _, behind = shortened(" ".join(words), most).partition(" ... ")
            assert before.split() == words[: len(before.split())]
            assert behind.split() == words[len(words) - len(behind.split()) :]


@given(st.text())
def test_a_message_is_one_short_line(text):
    """Whatever it says."""
    message = one_line(text)
    assert len(message) <= LONGEST_MESSAGE
    assert len(message.splitlines()) <= 1


def test_names_of_files_are_safe_and_apart():
    """Whatever the texts: parents of a folder, hidden names, nothing at all, one name twice."""
    stems = file_stems(["arp:k2=1.5", "../../etc", ".hidden", "", "ARP k2 1.5", "arp k2 1.5 2"])
    assert stems == ["arp-k2-1.5", "etc", "hidden", "unnamed", "arp-k2-1.5-2", "arp-k2-1.5-2-2"]


SEEN = st.text(st.characters(exclude_categories=("C", "Zl", "Zp")))


@given(st.lists(SEEN, min_size=1))
def test_a_shown_command_is_read_as_its_words(words):
    """By a shell, whatever stands in a word; and nothing in the command is hidden."""
    shown = command_text(*words)
    assert shlex.split(shown) == words
    assert visible(shown) == shown


@pytest.mark.skipif(shutil.which("bash") is None, reason="bash reads these words")
@pytest.mark.parametrize("word", ["a\ntouch X", "\x1b[2J'\\", "\u202eb c", "name\udc80", "\x9b;touch X;"])
def test_hidden_characters_of_a_command_are_written_out_and_read_again(word):
    """A line break in a name ends no command, and the name stays what it is."""
    shown = command_text("printf", "%s", word)
    assert visible(shown) == shown
    bash = subprocess.run(["bash", "-c", shown], env={"LC_ALL": "C.UTF-8"}, capture_output=True, check=True)
    assert bash.stdout == word.encode(errors="surrogateescape")


def test_half_a_character_in_a_command_is_written_out():
    """One that no name of a file has, as JSON may hold it."""
    assert command_text("a\ud800") == "$'a\\xed\\xa0\\x80'"


def test_a_path_is_no_flag():
    """A folder whose name begins with a hyphen is named by its place."""
    assert command_text("harness", "report", Path("-x"), "--details") == "harness report ./-x --details"


def test_no_command_is_put_together_by_hand():
    """Where a folder, a file or a name stands in a command, `command_text` quotes it."""
    root, shown = Path(harness.__file__).parents[1], re.compile(r"""f".*\bharness [a-z-]+ (--[a-z-]+ )*["']?\{""")
    sources = [path for part in ("harness", "plugins") for path in (root / part).rglob("*.py")]
    told = [f"{path}: {line.strip()}" for path in sources for line in path.read_text("utf-8").splitlines()]
    assert [line for line in told if shown.search(line) and "harness run {EXPERIMENT}" not in line] == []


@pytest.mark.parametrize(
    ("value", "text"),
    [(41.23, "41.2"), (-0.01, "-0.01"), (1e-17, "0"), (7257.9, "7,258"), (0.0, "0"), (2.5e12, "2.5e+12"), (1.0, "1")],
)
def test_numbers_read_well(value, text):
    """Three digits, no needless exponent."""
    assert number(value) == text
