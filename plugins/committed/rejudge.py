"""Records that were written down earlier, judged by the rule of this version: their seeds' values are all it needs.

``python -m harness_plugins.committed.rejudge FOLDER ...`` rewrites the answers in ``results.json`` and ``summary.md``
of folders that ``harness report DIR --summary FOLDER`` wrote, where the trainings themselves are not at hand any more.
"""

import json
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from harness.authoring.commands import ENDED, Comparison, pools_of, with_verdicts, write_whole
from harness.authoring.pages import TESTS, answer_text, behaviour_row, rewards_text, word_of

from .markdown import escape, pooled_part
from .stored import behaviour_of, stored_comparisons, studied_comparisons

RECORD, PAGE = "results.json", "summary.md"
NOTICE = (
    "The answers on this page follow a rule that was chosen after these results had been seen. Nothing was trained "
    "again, and what was measured is unchanged. The p-values and intervals of what does not decide are those of the "
    "first report."
)
EARLIER_NOTICE = re.compile(r"^\nThe answers on this page follow a rule .*\n")
EARLIER_TESTS = re.compile(r"p(?:: | says )how often chance alone .*$", re.MULTILINE)
OF_ALL, MADE_ANEW = ("failed", "trainings"), ("low", "high", "p", "p_corrected", "result")
"""What this version says of every measure, and what follows by its rule for those that decide."""
DIFFERENCE, P = 3, -2
"""Columns of a table of behaviour: the interval; from here on the p-value and the result."""


def judged_anew(combinations: Sequence[Mapping[str, Any]]) -> tuple[Comparison, ...]:
    """Comparisons with answers, of what ``harness report --json`` says of them.

    They hold the measures of behaviour and their seeds' values, and nothing of the rewards.

    Args:
        combinations: The key of that name.
    """
    return with_verdicts([behaviour_of(it) for it in combinations])


def rejudge(folder: Path) -> None:
    """Rewrite the answers of a record.

    Args:
        folder: What ``harness report DIR --summary FOLDER`` or ``harness rewards DIR --summary FOLDER`` wrote.

    Raises:
        OSError: There is no such record.
        ValueError: Its page does not hold the answers of its file; or the plan has looks, or was not trained to its
            end, and then a record does not hold what its answers follow from.
    """
    record = json.loads((folder / RECORD).read_text(encoding="utf-8"))
    _require_ended(record)
    told = list(stored_comparisons(record))
    judged = judged_anew(told)
    page = (folder / PAGE).read_text(encoding="utf-8")
    page = _page(page, told, judged)
    for it, comparison in zip(told, judged, strict=True):
        _rewrite(it, comparison)
    if record.get("combinations"):
        anew = {(it.group.task.label, it.group.algorithm.label, it.baseline, it.proposed): it for it in judged}
        for it in studied_comparisons(record):
            _rewrite(it, anew[it["task"], it["algorithm"], it["baseline"], it["proposed"]])
        record["over_places"] = [pool.to_json() for pool in pools_of(judged)]
    write_whole(folder / RECORD, json.dumps(record, indent=1, allow_nan=False) + "\n")
    write_whole(folder / PAGE, page)


def _require_ended(record: Mapping[str, Any]) -> None:
    """See that all trainings count at once, and that none is still to come."""
    if (record.get("terms") or {}).get("looks"):
        raise ValueError(f"{RECORD} is of a plan with looks: report its folder again")
    if to_come := sum(cell["status"] not in ENDED for cell in record.get("cells", ())):
        raise ValueError(f"{RECORD} is of a plan of which {to_come} trainings are still to come: it has no answers")


def _rewrite(told: dict[str, Any], comparison: Comparison) -> None:
    """The answer of one comparison, and the p-values that it rests on."""
    answer = comparison.headline.to_json()
    headline = told["headline"]
    sentence = answer.pop("behaviour")
    for key in ("robot", "agent", "behaviour"):
        if key in headline:
            headline[key] = sentence
    headline |= {key: value for key, value in answer.items() if key in headline and key not in ("number", "robot")}
    told["test"] = comparison.answer.ruling and comparison.answer.ruling.to_json()
    told["trained"] = comparison.trained_by
    told.pop("learns", None)  # up to version 0.2 a question of its own
    ruled = {id(it) for it in comparison.decisive_changes}
    for measure, change in zip(told["behaviour"], comparison.measured.changes, strict=True):
        measure.pop("values", None)  # up to version 0.2 in pairs
        keys = (*OF_ALL, *MADE_ANEW) if id(change) in ruled else OF_ALL
        measure |= {key: value for key, value in change.to_json().items() if key in keys}


def _page(page: str, told: Sequence[Mapping[str, Any]], judged: Sequence[Comparison]) -> str:
    """The page with the answers of the comparisons, in their order."""
    begin, ends = 0, list[int]()
    for it in told:
        before = re.escape(escape(_sentence(it)))
        found = re.compile(rf"\*\*The (robot|agent): [A-Z ]+\.\*\* {before}").search(page, begin)
        if found is None:
            raise ValueError(f"{PAGE} does not say: {_sentence(it)}")
        begin = found.end()
        ends.append(begin)
    parts = [page[one:other] for one, other in zip([0, *ends], [*ends, len(page)], strict=True)]
    for number, (it, comparison) in enumerate(zip(told, judged, strict=True)):
        headline = comparison.headline
        sentence = f"**The {comparison.group.subject}: {answer_text(headline)}.** {escape(headline.robot)}"
        earlier = parts[number].rindex("**The ")
        parts[number] = parts[number][:earlier] + sentence
        parts[number + 1] = _with_measures(parts[number + 1], comparison)
        parts[0] = _in_overview(parts[0], number, it, comparison)
    tests = TESTS.format(subject=judged[0].group.subject)
    parts[0] = _at_head(EARLIER_TESTS.sub(tests, parts[0]), judged)
    return parts[0] + "".join(EARLIER_TESTS.sub(tests, part) for part in parts[1:])


def _sentence(told: Mapping[str, Any]) -> str:
    headline = told["headline"]
    sentence: str = headline.get("robot") or headline.get("agent") or headline["behaviour"]
    return sentence


def _in_overview(page: str, number: int, told: Mapping[str, Any], comparison: Comparison) -> str:
    """The page with the answer in the table of all combinations, where there is one."""
    before = f"| {told['headline']['answer'].upper()} |"
    rewards = escape(rewards_text(comparison))
    row = re.compile(rf"^\| {number + 1} \|.*\| {re.escape(rewards)} {re.escape(before)}", re.MULTILINE)
    after = f"| {word_of(comparison.headline.answer)} |"
    return row.sub(lambda found: found.group().removesuffix(before) + after, page)


def _with_measures(page: str, comparison: Comparison) -> str:
    """The page with the intervals and p-values of the measures that decide, in the tables of their manner."""
    for change in comparison.decisive_changes:
        cells = [escape(text) for text in behaviour_row(change)]
        heading = re.compile(rf"^Behaviour .*{re.escape(change.measure.manner)}", re.MULTILINE).search(page)
        row = re.compile(rf"^\| {re.escape(cells[0])} \|.*\|$", re.MULTILINE)
        found = heading and row.search(page, heading.end())
        if found:
            kept = found.group().strip("| ").split(" | ")
            line = [*kept[:DIFFERENCE], cells[DIFFERENCE], *kept[DIFFERENCE + 1 : len(cells) + P], *cells[P:]]
            page = f"{page[: found.start()]}| {' | '.join(line)} |{page[found.end() :]}"
    return page


def _at_head(page: str, judged: Sequence[Comparison]) -> str:
    """The page with the notice behind its title, and the answers over all places before the first section."""
    title, rest = page.split("\n", 1)
    rest = f"\n{NOTICE}\n{EARLIER_NOTICE.sub('', rest)}"
    before, heading, behind = rest.partition("\n## 1. ")
    pooled = pooled_part(judged)
    if heading and pooled:
        without, *_ = before.partition(f"\n{pooled[0]}\n")
        before = without + "\n" + "\n\n".join(pooled) + "\n"
    return f"{title}\n{before}{heading}{behind}"


if __name__ == "__main__":
    for name in sys.argv[1:]:
        rejudge(Path(name))
