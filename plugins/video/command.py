"""``harness video``: recorded episodes as a film."""

from pathlib import Path
from typing import Annotated

import typer

from harness.cli.flags.shared import ExperimentFolder, PluginFiles
from harness.cli.output import say
from harness.errors import UsageError

MOST_CELLS = 4


def video(
    folder: ExperimentFolder,
    cells: Annotated[
        list[str] | None,
        typer.Option(
            help=f"Cells to show side by side, at most {MOST_CELLS}: their ids, or the first letters of these. "
            "(default: the first comparison)",
            metavar="ID,...",
        ),
    ] = None,
    episodes: Annotated[int, typer.Option(help="How many episodes.", metavar="N", min=1, max=100)] = 3,
    out: Annotated[Path, typer.Option(help="The film: .gif or .mp4.", metavar="FILE")] = Path("replay.gif"),
    plugin: PluginFiles = None,
) -> None:
    """Make a film of recorded episodes: the arm, its target, what it is paid. Needs no simulator and no screen.

    If the task is an environment, the policies play their evaluations again and the environment draws the pictures.
    """
    from harness import load_results
    from harness.registry import split_list
    from harness.results.replay import first_show, show_cells

    from .film import film_of, require_kind, write_film

    require_kind(out)
    results = load_results(folder, plugins=plugin or ())
    named = split_list(cells or [])
    if len(named) > MOST_CELLS:
        raise UsageError(f"--cells names {len(named)} cells, {MOST_CELLS} are allowed")
    if results.in_environment:
        from .environment_film import environment_film

        write_film(environment_film(results, named, episodes), out)
    else:
        show = show_cells(results, named, episodes) if named else first_show(results, episodes)
        write_film(film_of(show), out)
    say(f"Video: {out} ({out.stat().st_size / 1e6:.2f} MB)", err=True)


video.examples = ("harness video my-results --out film.gif",)  # type: ignore[attr-defined] # harness shows them
