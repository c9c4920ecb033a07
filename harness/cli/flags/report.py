"""The flags of ``harness report`` that no other command has."""

from pathlib import Path
from typing import Annotated

import typer

ExperimentFolders = Annotated[
    list[Path],
    typer.Argument(
        help="The folder of an experiment. Several folders are read as if one run had made them.", metavar="DIR..."
    ),
]
HtmlFile = Annotated[Path | None, typer.Option(help="Write the report page to this file.", metavar="FILE")]
Details = Annotated[
    bool,
    typer.Option(
        "--details", help="Print every number of every comparison. With many comparisons this fills many screens."
    ),
]
Pairs = Annotated[
    bool,
    typer.Option(
        "--pairs",
        help="Compare every two rewards, not each with the baseline alone. All claims are corrected together. In "
        "environments that is always so.",
    ),
]
SummaryFolder = Annotated[
    Path | None,
    typer.Option(
        help="Write records into this folder: small tables and figures, made to be kept and shared.", metavar="FOLDER"
    ),
]
MeasureFiles = Annotated[
    list[str] | None,
    typer.Option(
        "--measure",
        help="A Python file whose functions measure what an arm does; can be repeated. Of logs: what decides, such as "
        "success or length:better=lower. return decides where one and the same reward paid all of them.",
        metavar="FILE|NAME",
        show_default=False,
    ),
]
