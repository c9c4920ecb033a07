"""Acting for a budget of steps without learning: the training of algorithms such as ``random`` and ``ik``."""

import numpy as np

from harness.algorithm import TrainingEnv
from harness.authoring.generator_state import pack_generator, restore_generator
from harness.policy import Policy
from harness.record.progress import Progress, TrainingState, as_state

TELL_EVERY, RESTART_EVERY = 100, 500
"""Decisions from one word of progress to the next, and from one start of new episodes in all envs to the next."""


def act_for(env: TrainingEnv, steps: int, policy: Policy, seed: int, progress: Progress) -> None:
    """Let a policy draw actions. Now and then all envs start new episodes.

    Args:
        env: Trained on; it counts the steps.
        steps: Environment steps to take, over all envs, exactly.
        policy: Draws.
        seed: For the generator that it draws with.
        progress: Is told, and keeps checkpoints; the training goes on from one.
    """
    rng, state = np.random.default_rng(seed), progress.restored()
    if state is None:
        (observation, _), done, decisions = env.reset(), 0, 0
    else:
        restore_generator(rng, state["rng"])
        observation, done, decisions = state["observation"], int(state["done"]), int(state["decisions"])
    before = env.environment_steps - done

    def standing() -> TrainingState:
        return as_state({"rng": pack_generator(rng), "observation": observation, "done": done, "decisions": decisions})

    while done < steps:
        observation, *_ = env.step(policy.act(observation, rng))
        done, decisions = env.environment_steps - before, decisions + 1
        if decisions % TELL_EVERY == 0 or done >= steps:
            progress(done)
            progress.policy(done, lambda: policy)
        if decisions % RESTART_EVERY == 0 and done < steps:
            observation, _ = env.reset()
        progress.checkpoint(done, standing)
