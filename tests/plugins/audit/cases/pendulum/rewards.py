"""Rewards for a pendulum that shall stand in the end; every episode has 200 steps."""


class late:  # noqa: N801
    """The height, and from step 150 on the speed, 5 times. Hacked: standing up first and spinning later pays more."""

    def reset(self):
        """Begin an episode."""
        self.steps = 0

    def __call__(self, observation, action, next_observation, info):
        """Pay a step."""
        self.steps += 1
        return 5.0 * abs(float(next_observation[2])) if self.steps > 150 else float(next_observation[0])


def lively(observation, action, next_observation, info):
    """The height, and a cost of speed whose sign is wrong. Hacked: spinning pays up to 4 a step, standing 1."""
    return {"height": float(next_observation[0]), "speed": 0.5 * abs(float(next_observation[2]))}


def tiny(observation, action, next_observation, info):
    """The height in millionths. Honest: standing pays most in each step."""
    return 1e-6 * float(next_observation[0])


def huge(observation, action, next_observation, info):
    """The height in millions, and an offset. Honest: all episodes are equally long."""
    return 1e6 * float(next_observation[0]) + 1e6


def shaped(observation, action, next_observation, info):
    """1 while it stands, and shaping by a potential for a learner that discounts by 0.99. Honest by the theorem."""
    stands = float(next_observation[0] > 0.95 and abs(next_observation[2]) < 1.0)
    return stands + 0.99 * 3.0 * float(next_observation[0]) - 3.0 * float(observation[0])
