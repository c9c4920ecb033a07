"""Rewards and measures of the recorded trainings, beside those of the audit's cases."""

import math


class cost:  # noqa: N801
    """Of a pendulum: the squared angle from upright and a tenth of the squared speed, mean of the steps so far."""

    def reset(self):
        """Begin an episode."""
        self.total, self.steps = 0.0, 0

    def __call__(self, step):
        """Look at a step."""
        cosine, sine, speed = (float(it) for it in step.observation)
        self.total, self.steps = self.total + math.atan2(sine, cosine) ** 2 + 0.1 * speed**2, self.steps + 1
        return self.total / self.steps


def distance(step):
    """From Reacher's fingertip to its target, [m]; less is better."""
    return math.hypot(step.observation[8], step.observation[9])


def away(step):
    """That distance as a reward. Hacked: the sign is wrong, so the farther the fingertip is the better."""
    return distance(step)


def to_dock(step):
    """From a ship to its dock; less is better."""
    return math.hypot(*step.observation["position"])


def still(step):
    """Minus what moves. Hacked: there are only costs, so the sooner the pole falls the better."""
    _, speed, angle, turning = (abs(float(it)) for it in step.observation)
    return -0.1 - speed - angle - turning


def idle(step):
    """Minus the force, and a cost of each step. Hacked: falling soon ends the costs."""
    return -0.1 - abs(float(step.action[0]))


def alive(step):
    """1 a step. Honest: standing longer pays more."""
    return 1.0


def high(step):
    """How high Acrobot's end is. Hacked: the line ends the pay, and swinging below it goes on for 500 steps."""
    return 2.0 + height(step)


def over(step):
    """Whether Acrobot's end is above the line."""
    return height(step) > 1.0


def height(step):
    """Of Acrobot's end over its bar, in links."""
    c1, s1, c2, s2, _, _ = (float(it) for it in step.observation)
    return -c1 - (c1 * c2 - s1 * s2)
