"""To act for a budget without learning: what the floor and the ceiling of a comparison do for a training."""

from typing import TYPE_CHECKING

import numpy as np

from harness.authoring.generator_state import pack_generator, restore_generator
from harness.policy import Policy
from harness.progress import Progress, TrainingState, as_state

if TYPE_CHECKING:
    from harness.env import ReachVectorEnv

TELL_EVERY, RESTART_EVERY = 100, 500
"""Decisions from one word of progress to the next, and from one start of new episodes in all envs to the next."""


def act_for(env: "ReachVectorEnv", steps: int, policy: Policy, seed: int, progress: Progress) -> None:
    """Let `policy` draw actions for `steps` environment steps.

    Now and then all envs start new episodes, so that a checkpoint is possible there.
    """
    rng, done = np.random.default_rng(seed), 0
    state = progress.restored()
    if state is not None:
        restore_generator(rng, state["rng"])
        done = int(state["done"])
    before, decisions = env.environment_steps - done, 0

    def standing() -> TrainingState:
        return as_state({"rng": pack_generator(rng), "done": done})

    observation, _ = env.reset()
    while done < steps:
        observation, *_ = env.step(policy.act(observation, rng))
        done, decisions = env.environment_steps - before, decisions + 1
        if decisions % TELL_EVERY == 0 or done >= steps:
            progress(done)
            progress.policy(done, lambda: policy)
        if decisions % RESTART_EVERY == 0 and done < steps:
            progress.checkpoint(done, standing)
            observation, _ = env.reset()
