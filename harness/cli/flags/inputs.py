"""Which flags go with what a command is given: what would change nothing is refused."""

from typing import Final

import typer

from harness.errors import UsageError

TASK, ENVIRONMENT, ANY_EXPERIMENT, CERTIFICATE = "a task", "an environment", "an experiment", "a certificate"
EXPERIMENT, ENVIRONMENTS = "an experiment with an arm", "an experiment in environments"
RECORDINGS, LOGS, DATASET = "a folder of recorded trainings", "logs of trainings", "a data set"
RECORDS, STEPS, GROUPS, FILES = "committed records", "files of steps", "files of steps in two groups", "files"
SHOWN, TOLD = "--curve --json --leave-out --ends", "--sort --labels --per-step"
REPORTED = f"{SHOWN} --html --details --metric --pairs --fail-on"
OF_STEPS = (
    "--as --baseline --proposed --baseline-reward --proposed-reward "
    "--curve --json --leave-out --plot --with-events --plugin"
)
SCORED = "--reward --plugin --json"
AUDITED = f"{SCORED} --task --fail-on"
SEARCHED = f"{AUDITED} --html --against --episodes --gamma --budget --starts --seed --from --policy --out"
FITTING: Final = {
    "report": {
        EXPERIMENT: f"{REPORTED} --summary --plugin --measure",
        ENVIRONMENTS: f"{REPORTED} --summary --plugin",
        RECORDINGS: f"{REPORTED} --baseline --measure --as",
        LOGS: f"{REPORTED} --baseline --measure --as {TOLD}",
        DATASET: "--json --html --labels --fail-on",
        RECORDS: "--json",
    },
    "eta": {
        EXPERIMENT: f"{SHOWN} --plot",
        RECORDINGS: f"{SHOWN} --plot --baseline --measure --as",
        LOGS: f"{SHOWN} --plot --baseline --proposed --measure --as {TOLD}",
        STEPS: f"{OF_STEPS} --sort",
        GROUPS: OF_STEPS,
    },
    "score": {
        EXPERIMENT: f"{SCORED} --all",
        RECORDINGS: f"{SCORED} --all --task",
        DATASET: f"{SCORED} --out --places --partial --robot",
        FILES: f"{SCORED} --out",
    },
    "audit": {
        TASK: f"{SEARCHED} --robot --sim",
        ENVIRONMENT: f"{SEARCHED} --success --measure",
        ANY_EXPERIMENT: f"{AUDITED} --random --leave-out",
        RECORDINGS: f"{AUDITED} --random --leave-out",
        LOGS: f"{AUDITED} --as --sort --leave-out",
        CERTIFICATE: "--replay --sim --plugin --measure --json",
        DATASET: f"{AUDITED} --html --robot --success --places --labels --success-above --cluster --partial --beginner",
    },
}
"""By command and by what it is given, the flags that it reads then."""


def unfit(context: typer.Context, given: str) -> list[str]:
    """The flags of a line that say nothing of what is given."""
    typed = {
        parameter.opts[0]
        for parameter in context.command.params
        if (source := context.get_parameter_source(parameter.name or "")) and source.name == "COMMANDLINE"
    }
    return sorted(it for it in typed if it.startswith("--") and it not in _fitting(context)[given].split())


def require_fit(context: typer.Context, given: str) -> None:
    """Check that every flag of a line says something of what is given.

    Raises:
        UsageError: One says nothing.
    """
    for flag in unfit(context, given)[:1]:
        others = [noun for noun, flags in _fitting(context).items() if flag in flags.split()]
        raise UsageError(f"{flag} does not go with {given}, only with {' or '.join(others)}: leave it out")


def _fitting(context: typer.Context) -> dict[str, str]:
    return FITTING[str(context.command.name)]
