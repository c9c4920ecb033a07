"""``harness doctor``. What looks around is imported when it is called: ``--help`` does not wait for it."""

import typer


def doctor(context: typer.Context) -> int:
    """Show what is installed, what is missing, and what works here. Simulators and environments take a step each.

    Ends with status 1 if a plugin is broken, a file of the installation is missing, or something installed fails.
    """
    from .doctor import show_installation

    return show_installation(context.obj)


vars(doctor)["examples"] = ("harness doctor",)
