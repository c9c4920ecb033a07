"""What is said of logs and data sets of others is right, or a question; and whatever it tells to type leads on."""

import shlex
from dataclasses import replace

import pytest

from tests.laws.cases import ASKED, CASES, is_untrue
from tests.laws.said import INTERIM, REFUSED, remedies, say, shown, typed

DEEPEST = 3
"""Questions that one has to answer at most."""


@pytest.fixture
def there(tmp_path, monkeypatch):
    """Writes a case, and stands where its line is typed."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "100")

    def write(case):
        (tmp_path / case.name).mkdir()
        case.write(tmp_path / case.name)
        return shlex.split(case.line)

    return write


def followed(case, said, deep=0, seen=None):
    """Types whatever an answer tells to type: yields each line with what is wrong with its answer.

    A question is right if one of its remedies leads to the right answer, and none to a wrong one.
    """
    seen = {said.line: False} if seen is None else seen
    led = False
    for remedy in remedies(said.text):
        try:
            line = typed(said.line, remedy, case.knows)
        except KeyError as word:
            yield remedy, f"nobody says what {word} is", led
            continue
        if line in seen:
            led = led or seen[line]
            continue
        seen[line] = False
        answer = say(line)
        if is_untrue(case, remedy):
            continue
        if case.without and "--leave-out" in remedy:
            wrong = "" if (answer.trainings, answer.word != INTERIM) == (case.without, True) else answer
        elif answer.word == REFUSED:
            deeper = [*followed(case, answer, deep + 1, seen)] if deep + 1 < DEEPEST else []
            yield from deeper
            wrong = "" if not case.wrong(answer) or any(it[2] for it in deeper) else answer.text
        else:
            wrong = replace(case, words=case.then or case.words).wrong(answer)
        led = led or not wrong
        seen[line] = not wrong
        yield line, wrong, led


@pytest.mark.parametrize("case", [*CASES, *ASKED], ids=lambda it: it.line.replace(" ", "_"))
def test_what_is_said_is_right_or_leads_there(there, case, record_property):
    """By words, shares and counts; every remedy that is printed is typed on the same input."""
    first = say(there(case))
    steps = [*followed(case, first)]
    record_property("remedies", len(steps))
    wrong = case.wrong(first)
    if wrong and first.word == REFUSED and case.is_asked and any(led for _, _, led in steps):
        wrong = ""
    told = [f"{shown(line)}: {it}" for line, it, _ in steps if it]
    assert not [*([f"{shown(first.line)}: {wrong}"] if wrong else []), *told]
