"""``harness run``: train every combination, compare, report."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from harness.cli.interrupted import kept_when_interrupted
from harness.cli.lines import complain, say
from harness.cli.options import CurveKind, ExecutorName, Names, RewardNames, RobotName, TaskName
from harness.errors import UsageError

if TYPE_CHECKING:
    from harness.results import Results


def run(
    experiment: Annotated[
        Path | None, typer.Argument(help="Experiment file (TOML). Its keys are the flags below; a flag wins.")
    ] = None,
    sim: Annotated[Names, typer.Option(help="Simulators.", metavar="NAME,...")] = None,
    algo: Annotated[Names, typer.Option(help="Algorithms, as sac:learning_rate=1e-3.", metavar="NAME,...")] = None,
    reward: RewardNames = None,
    baseline: Annotated[
        str | None, typer.Option(help="What they are compared with.", show_default="baseline", metavar="NAME")
    ] = None,
    task: TaskName = None,
    robot: RobotName = None,
    seeds: Annotated[
        str | None, typer.Option(help="How many seeds, or a list (3,7,11).", show_default="6", metavar="N")
    ] = None,
    steps: Annotated[
        int | None, typer.Option(help="Environment steps of training per cell.", show_default="5000", metavar="N")
    ] = None,
    evaluation_episodes: Annotated[
        int | None, typer.Option(help="Episodes of an evaluation.", show_default="100", metavar="N")
    ] = None,
    evaluate_every: Annotated[
        int | None,
        typer.Option(help="Steps from one evaluation to the next.", show_default="at the end alone", metavar="N"),
    ] = None,
    deterministic: Annotated[
        bool | None,
        typer.Option(
            "--deterministic/--stochastic",
            help="Whether evaluated policies draw no actions.",
            show_default="they do not",
        ),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(help="The experiment's folder.", show_default="one under results/runs/", metavar="DIR"),
    ] = None,
    jobs: Annotated[
        int | None, typer.Option(help="Cells at once.", show_default="as many as cores", metavar="N")
    ] = None,
    executor: ExecutorName = "processes",
    checkpoint_every: Annotated[
        int | None,
        typer.Option(
            help="Steps from one checkpoint to the next, 0 for none; killed, a cell goes on there.",
            show_default="every ten minutes",
            metavar="N",
        ),
    ] = None,
    tensorboard: Annotated[
        bool, typer.Option("--tensorboard", help="Leave event files of scalars in each cell's folder too.")
    ] = False,
    curve: CurveKind = "accumulated",
    wait: Annotated[
        bool, typer.Option("--wait/--no-wait", help="Wait while another run is using the folder, or give up.")
    ] = True,
) -> int:
    """Train every simulator x algorithm x reward x seed and compare the rewards.

    A cell that is done is not run again: the same command goes on where it stopped.
    """
    from harness.cli.progress import LiveProgress
    from harness.experiment.experiment import RunOptions, prepare

    options = RunOptions(out, jobs, executor, checkpoint_every, tensorboard, curve, wait)
    given = {
        "sim": sim, "algo": algo, "reward": reward, "baseline": baseline, "task": task, "robot": robot,
        "seeds": _parse_seeds(seeds), "steps": steps, "evaluation_episodes": evaluation_episodes,
        "evaluate_every": evaluate_every, "deterministic": deterministic,
    }  # fmt: skip
    ready = prepare(_read(experiment, {key: value for key, value in given.items() if value is not None}), options)
    folder = ready.store.folder
    with (
        kept_when_interrupted("finished cells are kept", folder),
        ready.begin(lambda: complain(f"waiting for another run in '{folder}' to end")) as begun,
        LiveProgress(ready.plan.cells, begun.done) as progress,
    ):
        results = begun.run(progress)
    _show(results)
    return 1 if results.failed else 0


def _read(path: Path | None, flags: dict[str, Any]) -> Any:
    """The experiment of a file, of flags, or of both."""
    from harness.experiment.plan import check_experiment, read_experiment

    return check_experiment(flags) if path is None else read_experiment(path, flags)


def _parse_seeds(text: str | None) -> int | list[int] | None:
    if text is None:
        return None
    try:
        numbers = [int(part) for part in text.split(",") if part.strip()]
    except ValueError:
        numbers = []
    if not numbers:
        raise UsageError(f"--seeds {text}: give a number of seeds (3) or a list of seeds (3,7,11)")
    return numbers if "," in text else numbers[0]


def _show(results: "Results") -> None:
    """The comparison on standard output; what was written too."""
    from harness.cli.terminal import show
    from harness.files.sums import note_made
    from harness.record.out_folder import storage_errors
    from harness.record.store import REPORT
    from harness.report.comparison_table import comparison_table
    from harness.report.html import write_html

    show(comparison_table(results))
    with storage_errors(results.folder):
        results.write_table()
    say(f"Results: {results.folder}")
    try:
        with storage_errors(results.folder):
            write_html(results, results.folder / REPORT)
            note_made(results.folder / REPORT)
        say(f"Report:  {results.folder / REPORT}")
    except UsageError as error:  # the extra is missing: the results are there all the same
        say(f"No {REPORT}: {error}")
