"""Orders to the process of a check, done in this one."""

import json
from pathlib import Path

import pytest

from harness.record.folder import partial_folder
from harness_plugins.kit.inspection.finding import Asked, Finding
from harness_plugins.kit.inspection.inspection import ANSWER, TryPlugin, read_finding, read_outline


@pytest.fixture
def done(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The folder that an order leaves."""
    monkeypatch.setattr("harness_plugins.kit.inspection.inspection.print_into", lambda path: None)

    def do(check: str | None) -> Path:
        folder = tmp_path / str(check)
        partial_folder(folder).mkdir()
        order = TryPlugin(Asked("dense"), str(tmp_path / "notes.txt"), check)
        assert TryPlugin.from_json(json.loads(json.dumps(order.to_json()))) == order
        assert order.do(folder, lambda word: None)
        return folder

    return do


def test_without_a_check_the_plugin_is_outlined(done):
    """Its kind, and the checks that there are."""
    outline = read_outline(done(None))
    assert outline is not None
    assert outline.kind == "rewards"
    assert "reward-finite-edges" in [check.name for check in outline.checks]


def test_check_leaves_its_finding(done):
    """A sound reward passes it."""
    found = read_finding(done("reward-finite-edges"))
    assert isinstance(found, Finding)
    assert (found.check, found.verdict) == ("reward-finite-edges", "ok")


@pytest.mark.parametrize("text", [None, "", "{"])
def test_answer_that_is_not_there_or_no_json_is_none(tmp_path: Path, text: str | None):
    """A plugin may remove what is not its own."""
    if text is not None:
        (tmp_path / ANSWER).write_text(text)
    assert read_finding(tmp_path) is None
    assert read_outline(tmp_path) is None
