"""`harness audit --out`, `--html` and `--replay`: what one types and sees."""

import pytest

SEARCHED = ("audit", "--reward", "arp", "--episodes", 2, "--budget", 3000, "--starts", 1)


@pytest.fixture
def cheats(harness, tmp_path):
    """A folder with what a short search found."""
    answer = harness(*SEARCHED, "--out", "cheats", "--html", "page.html")
    assert answer.status == 0, answer.err
    assert "Certificates: cheats, their page: cheats/index.html" in answer.err
    return tmp_path / "cheats"


def test_a_search_leaves_certificates_and_their_page(cheats, harness):
    """In the folder; the page alone in the file. Each is played again, and says that it is the same."""
    assert {"index.html", "scene.json", "arp-failure.json"} <= {path.name for path in cheats.iterdir()}
    assert 'id="replay-player"' in (cheats / "index.html").read_text()
    page = (cheats.parent / "page.html").read_text()
    assert 'id="replay-player"' in page
    assert "--replay" not in page
    answer = harness("audit --replay cheats/arp-failure.json")
    assert (answer.status, answer.out[:10]) == (0, "the same: ")
    answer = harness("audit --replay cheats/arp-failure.json --json")
    assert answer.json["same"] is True
    answer = harness("audit --replay cheats/arp-failure.json --sim ideal")
    assert (answer.status, answer.out[:10]) == (0, "in ideal: ")
