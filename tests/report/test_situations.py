"""Every sentence of the constructed situations is the one that a person has read."""

import re
from pathlib import Path

from harness.eta import Answer
from tests.report.situations import SITUATIONS, judged, whole_text

REVIEWED = Path(__file__).with_name("situations.txt")
CLAIM = re.compile(r"\b(better|worse|helps|hurts|faster|slower|slowly)\b")


def test_the_sentences_are_those_that_were_read():
    """After a change: python -m tests.report.situations > tests/report/situations.txt, and read what changed."""
    assert whole_text() + "\n" == REVIEWED.read_text()


def test_every_answer_has_a_situation():
    """But one that is the mirror of another."""
    answers = {it.headline.answer for situation in SITUATIONS for it in judged(situation)}
    answers |= {
        it.answer.pool.headline.answer
        for situation in SITUATIONS
        for it in judged(situation)
        if it.answer.pool is not None
    }
    assert set(Answer) - answers == {Answer.LEARNS_SLOWER}


def test_a_word_of_better_or_worse_stands_only_where_a_test_decided(subtests):
    """In the sentence and on the card."""
    for situation in SITUATIONS:
        with subtests.test(situation=situation):
            for it in judged(situation):
                if it.answer.ruling.is_decided or it.answer.pool is not None:
                    continue
                told = f"{it.headline.robot} {it.lead}".replace("Whether dense helps or hurts", "")
                assert not CLAIM.search(told.replace("lower is better", ""))
