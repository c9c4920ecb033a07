"""A reward for a pole that shall be balanced."""


def still(step):
    """Minus what moves. Hacked: there are only costs, so the sooner it falls the better."""
    _, speed, angle, turning = (abs(float(it)) for it in step.observation)
    return -0.1 - speed - angle - turning
