"""A reward and a measure of two links of which the free end shall swing above a line; 500 steps at most."""


def _height(observation):
    c1, s1, c2, s2, _, _ = (float(it) for it in observation)
    return -c1 - (c1 * c2 - s1 * s2)


def high(step):
    """How high the end is above its lowest place. Hacked: the line ends the pay, and swinging below it goes on."""
    return 2.0 + _height(step.observation)


def success(step):
    """Whether the end is above the line."""
    return _height(step.observation) > 1.0
