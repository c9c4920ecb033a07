"""Built-in environments."""

import harness

harness_api = 1


@harness.hookimpl
def register_environments(register: harness.Register) -> None:
    """Announce the built-in environments."""
    here = "harness_plugins.environments"
    register(
        "gymnasium",
        f"{here}.any_gymnasium:AnyGymnasium",
        summary="any id of Gymnasium, paid by its own reward and by numbers that it tells: gymnasium:id=Pendulum-v1",
    )
