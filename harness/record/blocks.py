"""What the episodes of a training came to, in blocks that do not overlap: what is shown of it while it goes on.

A cell of an arm keeps the file ``blocks.json`` in its folder while it trains; who looks from another process reads it.
Recordings and traces give the same blocks when they are read.
"""

from dataclasses import dataclass

MOST = 64
"""The most blocks of a training. Where there would be more, each two become one."""


@dataclass(frozen=True)
class Block:
    """Consecutive episodes of a training, in the order in which they ended.

    All blocks of a training have the same number of episodes, a power of two; the last one may have fewer.

    Attributes:
        steps: Environment steps of the training, over all its envs, when the last of them had ended.
        episodes: How many.
        pay: What an episode was paid, mean.
        pay_spread: Standard deviation of what an episode was paid, divided by `episodes` - 1; NaN of one.
        behaviour: Success, as a share, or the first measure; mean of an episode. NaN where nothing measures it.
        behaviour_spread: Its standard deviation; NaN of one.
    """

    steps: int
    episodes: int
    pay: float
    pay_spread: float
    behaviour: float
    behaviour_spread: float
