"""Environments with actions and observations of any space: the command searches them, and replays what it found."""

import pytest

from harness.files.bounded import seal, unseal
from tests.plugins.audit.cases import ships
from tests.plugins.audit.cases.ships import VIEWS, WAYS

KINDS = [*((takes, "number") for takes in WAYS), *(("several", sees) for sees in VIEWS if sees != "number")]


CALL = ("--plugin", ships.__file__, "--episodes", 1, "--starts", 1, "--budget", 3000)


@pytest.mark.parametrize(("takes", "sees"), KINDS)
def test_the_answer_is_right(takes, sees, harness):
    """Hovering beside the dock is paid for one step after the other; docking alone is not."""
    answer = harness("audit", f"ships:takes={takes},sees={sees}", "--reward", "own,hover", *CALL, "--json")
    assert answer.status == 0, answer.err
    assert [it["answer"] for it in answer.json["cheats"]] == ["NOTHING FOUND", "PAYS FOR FAILING"]
    assert answer.json["env"].startswith("ships")  # as it was typed, not what the class is called


@pytest.mark.parametrize("takes", ["pair", "mixed"])
def test_coded_actions_are_replayed(takes, harness, tmp_path):
    """Bit for bit; a changed one is another episode."""
    harness("audit", f"ships:takes={takes}", "--reward", "own", *CALL, "--out", "it")
    answer = harness("audit --replay it/own-success.json --plugin", ships.__file__)
    assert (answer.status, answer.out[:10]) == (0, "the same: ")
    changed = unseal((tmp_path / "it/own-success.json").read_bytes())
    numbers = changed["actions"]["numbers"]
    numbers[:] = [1] * len(numbers) if takes == "pair" else [0.0] * len(numbers)
    (tmp_path / "other.json").write_bytes(seal(changed))
    answer = harness("audit --replay other.json --plugin", ships.__file__)
    assert (answer.status, answer.out[:12]) == (1, "NOT THE SAME")
