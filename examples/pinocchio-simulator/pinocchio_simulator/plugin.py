"""Registers the simulator. Keep it light: every `harness` command imports it."""

import harness

harness_api = 2


@harness.hookimpl
def register_simulators(register: harness.Register) -> None:
    """Announce the simulator; `harness doctor` says where pinocchio is missing."""
    register(
        "pinocchio",
        "pinocchio_simulator.simulator:Pinocchio",
        summary="pinocchio's articulated body algorithm; the ground is seen, not felt",
        requires=["pinocchio"],
    )
