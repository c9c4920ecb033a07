"""The report as one HTML file that opens anywhere, offline."""

from pathlib import Path
from typing import Any

from harness.eta.headline import SUCCESS
from harness.report.behaviour_rows import BehaviourRow, along_grid, behaviour_grids, behaviour_row, seeds_grid
from harness.report.facts import shared_facts
from harness.report.figure import draw_panels
from harness.report.learning_figure import describe_learning, draw_learning
from harness.report.page import render_page, write_page
from harness.report.points import points_of_a_run
from harness.report.profile_figure import describe_profile, draw_profile
from harness.report.question import question
from harness.report.replay.section import replay_of
from harness.report.return_rows import EXPLANATION as RETURNS
from harness.report.return_rows import TITLE as RETURN_TITLE
from harness.report.return_rows import return_grid
from harness.report.rows import (
    NOTHING,
    PATHS,
    SCALES,
    SPLIT,
    TESTS,
    TOTAL,
    Grid,
    advice,
    answer_text,
    claims_text,
    count_cells,
    index_grid,
    interval_text,
    path_grid,
    ratio_grid,
    ratio_text,
    rewards_text,
    seeds_text,
    split_grid,
    sum_grid,
)
from harness.report.split_figure import draw_split
from harness.report.split_rows import describe_split
from harness.report.trajectory_figure import describe_trajectories, draw_trajectories
from harness.report.transfer_rows import EXPLANATION, TITLE, failure_lines, transfer_block
from harness.results import Results
from harness.results.combination import Combination
from harness.results.learning import learning_of
from harness.results.replay import shows_of
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
    """In plain words: what was compared."""
    group, seeds = combination.group, combination.seeds
    if not seeds:
        return f"{combination.proposed} was to be compared with {combination.baseline}, but {combination.eta_n.note}."
    paid = (
        f"twice paid by {combination.baseline}, the second time with other seeds"
        if combination.is_control
        else f"once paid by {combination.baseline}, once by {combination.proposed}"
    )
    return (
        f"The robot {group.robot} learned {group.task.label} in {group.labels['simulator']} with "
        f"{group.algorithm.label}, {group.steps:,} environment steps per run, {seeds_text(seeds)}: {paid}. {SCALES}"
    )


def _render(results: Results) -> str:
    points = points_of_a_run(sum(2 * len(combination.seeds) for combination in results.combinations))
    return render_page(
        TEMPLATE,
        "The HTML report",
        question=question(results),
        nothing=NOTHING,
        sections=[_section(results, combination, points) for combination in results.combinations],
        split=SPLIT,
        paths=f"{PATHS} {TOTAL}",
        tests=TESTS,
        cell_count=count_cells(results),
        returns=_returns(return_matrices(results)),
        replay=replay_of(shows_of(results)),
        transfer=_transfer(load_transfers(results)),
        manifests=results.manifests,
        facts=shared_facts(results.manifests),
        experiment=results.experiment_text,
    )


def _section(results: Results, combination: Combination, points: int) -> dict[str, Any]:
    """What the template shows of a combination, `points` of each run."""
    headline = combination.headline
    return {
        "title": combination.group.title,
        "rewards": rewards_text(combination),
        "proposed": combination.names.proposed,
        "answer": answer_text(headline),
        "badge": headline.answer.name.lower().replace("_", "-"),
        "robot": headline.robot,
        "number": headline.number,
        "mixtures": [mixture.text for mixture in combination.mixtures],
        "advice": advice(results, combination),
        "tests": claims_text(combination),
        "ratios": [(ratio_text(eta), interval_text(eta, missing="")) for eta in (combination.eta_n, combination.eta_p)],
        "success": _success(combination),
        "summary": describe_comparison(combination),
        "split_panels": _split_panels(combination),
        "behaviour": _full([*behaviour_grids(combination)[:1], along_grid(combination)]),
        "other_behaviour": _full([*behaviour_grids(combination)[1:], seeds_grid(combination)]),
        "eta_grids": _full(
            [
                ratio_grid(combination.splits),
                split_grid(combination.splits),
                path_grid(combination.splits),
                _sum_grid(combination),
            ]
        ),
        "panels": _label_panels(combination, points),
        "learning": _learning_panels(results, combination),
        "profiles": _profile_panels(combination),
        "trajectories": _trajectory_panels(results, combination),
        "grids": _full([index_grid(combination.decomposition, results.kind)]),
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


def _profile_panels(combination: Combination) -> list[dict[str, Any]]:
    """Which share of the seeds reaches how much success."""
    success = combination.success
    figure = draw_profile(success) if success else None
    if success is None or figure is None:
        return []
    return [{"heading": "Success over seeds", "figure": figure, "caption": describe_profile(success)}]


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


def _sum_grid(combination: Combination) -> Grid:
    return sum_grid(combination.decomposition.total if combination.decomposition else None)


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


def _label_panels(combination: Combination, points: int) -> list[dict[str, Any]]:
    """Each panel with its heading and, for those who cannot see it, what it shows."""
    panels = draw_panels(combination, points)
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
