"""Answers of the process of a check; what it is asked and answers is tested with the command, in tests/cli."""

import pytest

from harness_plugins.kit.inspection.finding import Finding, Outline
from harness_plugins.kit.inspection.inspection import ANSWER, read_answer


@pytest.mark.parametrize("kind", [Finding, Outline])
@pytest.mark.parametrize("text", [None, "", "{"])
def test_answer_that_is_not_there_or_no_json_is_none(tmp_path, text, kind):
    """A plugin may remove what is not its own."""
    if text is not None:
        (tmp_path / ANSWER).write_text(text)
    assert read_answer(kind, tmp_path) is None
