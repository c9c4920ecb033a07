"""Records that were written down earlier, judged by the rule of this version."""

import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from harness.report.rows.comparison import answer_text
from harness_plugins.committed.rejudge import NOTICE, judged_anew, rejudge
from harness_plugins.committed.stored import stored_comparisons

REFERENCE = Path(__file__).parents[3] / "results" / "reference"
RECORDS = sorted(path.parent for path in REFERENCE.glob("**/results.json"))
JUDGED_ANEW = [it for it in RECORDS if NOTICE in (it / "summary.md").read_text(encoding="utf-8")]
"""Those that were made before the rule."""


def record_of(folder: Path) -> dict[str, Any]:
    """What ``results.json`` holds."""
    record: dict[str, Any] = json.loads((folder / "results.json").read_text(encoding="utf-8"))
    return record


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A record to write into: three comparisons, one of them decided."""
    folder = tmp_path / "reach"
    folder.mkdir()
    for name in ("results.json", "summary.md"):
        shutil.copy(REFERENCE / "meta-world" / "reach" / name, folder)
    return folder


@pytest.mark.parametrize("folder", JUDGED_ANEW, ids=lambda it: it.relative_to(REFERENCE).as_posix())
def test_a_record_has_the_answers_of_this_rule(folder: Path):
    """In its data and on its page."""
    told = list(stored_comparisons(record_of(folder)))
    page = (folder / "summary.md").read_text(encoding="utf-8")
    for stored, judged in zip(told, judged_anew(told), strict=True):
        headline = stored["headline"]
        assert headline["answer"] == judged.headline.answer.value
        assert headline.get("robot", headline.get("agent")) == judged.headline.robot
        assert f".{answer_text(judged.headline)}.** ".replace(".", "", 1) in page


def test_the_earlier_records_were_all_judged_anew():
    """Ninety-two comparisons: eighteen are decided by themselves, and twenty-one more over all of their places."""
    judged = [list(judged_anew(list(stored_comparisons(record_of(it))))) for it in JUDGED_ANEW]
    claims = [it for comparisons in judged for it in comparisons if not it.is_control]
    alone = [it for it in claims if it.answer.ruling.is_decided]
    together = [
        it for it in claims if not it.answer.ruling.is_decided and it.answer.pool and it.answer.pool.ruling.is_decided
    ]
    small = [it for it in claims if it.answer.pool and it.answer.pool.headline.answer == "no difference"]
    assert (len(claims), len(alone), len(together), len(small)) == (92, 18, 21, 0)


def test_judging_again_changes_nothing(copy: Path):
    """A record that has the answers of this rule keeps every byte."""
    before = {path.name: path.read_bytes() for path in copy.iterdir()}
    rejudge(copy)
    assert {path.name: path.read_bytes() for path in copy.iterdir()} == before


def test_another_answer_is_replaced_on_the_page_and_in_the_data(copy: Path):
    """Whatever stood there before."""
    record = record_of(copy)
    first = next(stored_comparisons(record))["headline"]
    page = (copy / "summary.md").read_text(encoding="utf-8")
    right = f"**The agent: HELPS.** {first['agent']}".replace("<", "\\<")
    assert right in page
    (copy / "summary.md").write_text(page.replace(right, "**The agent: CANNOT TELL.** Who knows."), encoding="utf-8")
    for key in ("answer", "agent"):
        first[key] = {"answer": "cannot tell", "agent": "Who knows."}[key]
    (copy / "results.json").write_text(json.dumps(record), encoding="utf-8")
    rejudge(copy)
    assert right in (copy / "summary.md").read_text(encoding="utf-8")
    assert next(stored_comparisons(record_of(copy)))["headline"]["answer"] == "helps"


def test_the_answers_over_all_places_are_replaced_on_the_page(tmp_path: Path):
    """And nothing around them."""
    for name in ("results.json", "summary.md"):
        shutil.copy(REFERENCE / "arp-2021" / name, tmp_path)
    right = (tmp_path / "summary.md").read_text(encoding="utf-8")
    begin, end = right.index("\n## Over all places\n"), right.index("\n## 1. ")
    wrong = f"{right[:begin]}\n## Over all places\n\n* **HELPS.** Who knows.\n{right[end:]}"
    (tmp_path / "summary.md").write_text(wrong, encoding="utf-8")
    rejudge(tmp_path)
    assert (tmp_path / "summary.md").read_text(encoding="utf-8") == right


def test_a_page_of_another_record_is_refused(copy: Path):
    """Nothing is written then."""
    shutil.copy(REFERENCE / "fetch" / "reach" / "summary.md", copy)
    before = {path.name: path.read_bytes() for path in copy.iterdir()}
    with pytest.raises(ValueError, match=r"summary\.md does not say"):
        rejudge(copy)
    assert {path.name: path.read_bytes() for path in copy.iterdir()} == before


def test_hints_keep_the_p_values_of_the_first_report(copy: Path):
    """As the page says."""
    record = record_of(copy)
    hint = next(it for it in next(stored_comparisons(record))["behaviour"] if it["name"] == "distance")
    hint |= {"p": 0.25, "p_corrected": 0.5}
    (copy / "results.json").write_text(json.dumps(record), encoding="utf-8")
    rejudge(copy)
    again = next(it for it in next(stored_comparisons(record_of(copy)))["behaviour"] if it["name"] == "distance")
    assert (again["p"], again["p_corrected"]) == (0.25, 0.5)


@pytest.mark.parametrize(
    ("change", "why"),
    [
        ({"terms": {"looks": [2, 4]}}, "a plan with looks"),
        ({"cells": [{"status": "pending"}]}, "are still to come"),
    ],
)
def test_records_that_do_not_hold_what_answers_follow_from_are_refused(copy: Path, change: Any, why: str):
    """Of looks, and of a plan that was not trained to its end: they would get a word that no test gave."""
    (copy / "results.json").write_text(json.dumps(record_of(copy) | change), encoding="utf-8")
    with pytest.raises(ValueError, match=why):
        rejudge(copy)


def test_records_in_an_environment_are_judged_once(tmp_path: Path):
    """From version 0.2 on they tell each comparison twice; both get the answer of one question."""
    record = record_of(REFERENCE / "meta-world" / "reach")
    twice = [dict(it) for it in stored_comparisons(record)]
    told = list(stored_comparisons({"combinations": twice, "studies": record["studies"]}))
    assert len(told) == len(twice)
