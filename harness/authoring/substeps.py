"""How many physics steps a duration takes, for simulators that count them."""

from dataclasses import dataclass, field

from harness.errors import UsageError

ROUNDING = 1e-6


@dataclass(frozen=True)
class Substeps:
    """A number of physics steps per control period.

    Attributes:
        count: Physics steps in a control period.
        period: The control period, [s].
    """

    count: int
    period: float
    _known: dict[float, int] = field(default_factory=dict, init=False, compare=False, repr=False)

    def within(self, duration: float) -> int:
        """How many physics steps `duration` takes, a whole part of the control period [s].

        Raises:
            UsageError: That is not a whole number.
        """
        steps = self._known.get(duration)
        if steps is None:
            steps = self._known[duration] = self._count(duration)
        return steps

    def _count(self, duration: float) -> int:
        exact = self.count * duration / self.period
        steps = round(exact)
        if steps < 1 or abs(exact - steps) > ROUNDING:
            raise UsageError(
                f"substeps={self.count} cannot be divided into {self.period / duration:g} parts of a control period: "
                "choose substeps that the action's parts divide"
            )
        return steps
