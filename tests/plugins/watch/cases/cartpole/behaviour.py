"""A measure of a pole that shall be balanced."""


class stood:  # noqa: N801
    """For how many steps the pole has stood."""

    def reset(self):
        """Begin an episode."""
        self.steps = 0

    def __call__(self, step):
        """Look at a step."""
        self.steps += 1
        return float(self.steps)
