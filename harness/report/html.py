"""The report as one HTML file that opens anywhere, offline."""

from pathlib import Path
from typing import Any

from harness.eta.index import Ratio
from harness.eta.verdict import SUCCESS
from harness.record.store import EXPERIMENT
from harness.report.facts import shared_facts
from harness.report.figure import draw_panels
from harness.report.learning_figure import describe_learning, draw_learning
from harness.report.page import render_page, write_page
from harness.report.question import question
from harness.report.return_rows import EXPLANATION as RETURNS
from harness.report.return_rows import TITLE as RETURN_TITLE
from harness.report.return_rows import return_grid
from harness.report.rows import (
    NOTHING,
    PATHS,
    SCALES,
    SPLIT,
    BehaviourRow,
    Grid,
    behaviour_grid,
    behaviour_row,
    corrected_text,
    count_cells,
    index_grid,
    interval_text,
    ratio_grid,
    ratio_text,
    rewards_text,
    seeds_text,
    split_grid,
)
from harness.report.split_figure import draw_split
from harness.report.split_rows import describe_split
from harness.report.trajectory_figure import describe_trajectories, draw_trajectories
from harness.report.transfer_rows import EXPLANATION, TITLE, failure_lines, transfer_block
from harness.results import Results
from harness.results.combination import Combination
from harness.results.learning import learning_of
from harness.results.return_matrix import ReturnMatrix, return_matrices
from harness.results.trajectories import trajectories_of
from harness.transfer.matrix import Transfers, load_transfers

TEMPLATE = Path(__file__).parent / "report.html.j2"


def write_html(results: Results, path: Path) -> None:
    """Write the report to `path`, in one go: a reader finds the old file or the new one, whole.

    Raises:
        UsageError: A library of the extra ``report`` is missing, or `path` cannot be written.
    """
    write_page(_render(results), path, "The report")


def describe_comparison(combination: Combination) -> str:
    """In plain words: what was compared, and the numbers."""
    group, seeds = combination.group, combination.seeds
    if not seeds:
        return f"{combination.proposed} was to be compared with {combination.baseline}, but {combination.eta_n.note}."
    sentences = [
        f"The robot {group.robot} learned {group.task.label} in {group.labels['simulator']} with "
        f"{group.algorithm.label}, {group.steps:,} environment steps per run, {seeds_text(seeds)}: once paid by "
        f"{combination.baseline}, once by {combination.proposed}.",
        f"Of the reward accumulated while learning, {_read_out(combination)}.",
        SCALES,
    ]
    success = _success(combination)
    if success:
        sentences.append(
            f"Evaluated after training, without any reward and acting {group.manner}, the policies trained with "
            f"{combination.baseline} reach the target in {success.baseline} of the episodes, those trained with "
            f"{combination.proposed} in "
            f"{success.proposed}, random actions in {success.random}."
        )
    return " ".join(sentences)


def _render(results: Results) -> str:
    return render_page(
        TEMPLATE,
        "The HTML report",
        question=question(results),
        nothing=NOTHING,
        sections=[_section(results, combination) for combination in results.combinations],
        split=SPLIT,
        paths=PATHS,
        cell_count=count_cells(results),
        returns=_returns(return_matrices(results)),
        transfer=_transfer(load_transfers(results)),
        manifests=results.manifests,
        facts=shared_facts(results.manifests),
        experiment=(results.folder / EXPERIMENT).read_text(encoding="utf-8"),
    )


def _section(results: Results, combination: Combination) -> dict[str, Any]:
    """What the template shows of a combination."""
    corrected = corrected_text(combination, len(results.combinations))
    return {
        "title": combination.group.title,
        "rewards": rewards_text(combination),
        "proposed": combination.proposed,
        "verdict": combination.verdict,
        "basis": [line for line in (combination.basis, corrected) if line],
        "ratios": [(ratio_text(eta), interval_text(eta, missing="")) for eta in (combination.eta_n, combination.eta_p)],
        "success": _success(combination),
        "summary": describe_comparison(combination),
        "split_panels": _split_panels(combination),
        "eta_grids": _full([ratio_grid(combination.splits), split_grid(combination.splits)]),
        "panels": _label_panels(combination),
        "learning": _learning_panels(results, combination),
        "trajectories": _trajectory_panels(results, combination),
        "grids": _full([index_grid(combination.decomposition), behaviour_grid(combination)]),
    }


def _learning_panels(results: Results, combination: Combination) -> list[dict[str, Any]]:
    """The success rate during training, where it was evaluated then."""
    learning = learning_of(results, combination)
    if learning is None or SUCCESS not in learning.random:
        return []
    figure, caption = draw_learning(learning, SUCCESS), describe_learning(learning, SUCCESS)
    return [{"heading": "Success rate while learning", "figure": figure, "caption": caption}]


def _trajectory_panels(results: Results, combination: Combination) -> list[dict[str, Any]]:
    """Where the end effector went, under each reward."""
    trajectories = trajectories_of(results, combination)
    if trajectories is None:
        return []
    sides = (
        (f"Baseline: {combination.baseline}", trajectories.baseline),
        (f"Proposed: {combination.proposed}", trajectories.proposed),
    )
    return [
        {"heading": heading, "figure": figure, "caption": describe_trajectories(trajectories.seed, paths)}
        for (heading, paths), figure in zip(sides, draw_trajectories(trajectories), strict=True)
    ]


def _returns(matrices: list[ReturnMatrix]) -> dict[str, Any] | None:
    """What the template shows of returns under every reward; None before a cell is done."""
    if not matrices:
        return None
    blocks = [(matrix.group.title, return_grid(matrix)) for matrix in matrices]
    return {"title": RETURN_TITLE, "explanation": RETURNS, "blocks": blocks}


def _transfer(transfers: Transfers) -> dict[str, Any] | None:
    """What the template shows of transfer; None where none is recorded."""
    if not transfers.matrices:
        return None
    return {
        "title": TITLE,
        "explanation": EXPLANATION,
        "blocks": [transfer_block(matrix) for matrix in transfers.matrices],
        "failed": failure_lines(transfers.failed),
    }


def _full(grids: list[Grid]) -> list[Grid]:
    return [grid for grid in grids if grid.rows or grid.notes]


def _split_panels(combination: Combination) -> list[dict[str, Any]]:
    """eta_N and eta_P, each with its parts, and the same in words."""
    if not combination.is_split:
        return []
    drawn = [(name, split, draw_split(name, split)) for name, split in combination.splits.items()]
    return [
        {"heading": f"{name} = ruler x behaviour", "figure": figure, "caption": describe_split(name, split)}
        for name, split, figure in drawn
        if figure is not None
    ]


def _label_panels(combination: Combination) -> list[dict[str, Any]]:
    """Each panel with its heading and, for those who cannot see it, what it shows."""
    panels = draw_panels(combination)
    if panels is None:
        return []
    first, crossover = index_grid(combination.decomposition).rows[:2]
    return [
        {
            "heading": f"{role}: {reward}",
            "figure": figure,
            "caption": f"First negative step: {first[column]}. Cross-over step: {crossover[column]}.",
        }
        for column, role, reward, figure in (
            (1, "Baseline", combination.baseline, panels[0]),
            (2, "Proposed", combination.proposed, panels[1]),
        )
    ]


def _success(combination: Combination) -> BehaviourRow | None:
    """The row of the success rate, if it was measured."""
    return behaviour_row(combination.success) if combination.success else None


def _read_out(combination: Combination) -> str:
    """Both ratios in a sentence."""
    return " and ".join(_told(name, split.eta) for name, split in combination.splits.items())


def _told(name: str, ratio: Ratio) -> str:
    if ratio.near_zero is not None:
        return f"{name} says little, as an index is near zero"
    interval = interval_text(ratio, missing="")
    return f"{name} is {ratio_text(ratio)}" + (f" (95% interval {interval})" if interval else "")
