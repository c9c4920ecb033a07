"""Every error that this project raises on purpose.

::

    HarnessError
    ├── UsageError            what the user gave cannot be used: one line, exit status 2, nothing written
    │   └── AskedError        a file can be read in several ways: asks which is meant
    ├── PluginError           a plugin is broken: names the plugin, its distribution and the target
    ├── MissingSolid          a simulator lacks a collision shape of an arm: names the link
    ├── SimulationDiverged    a simulation or a reward gave NaN or infinity: the cell fails, the other cells go on
    ├── ContractViolation     a plugin breaks its interface's contract: names the check
    ├── StorageError          a results folder cannot be written: the disk is full, or fails; what was done stays
    ├── Unscored              a reward cannot pay recorded runs again: the rest of a report stands
    ├── Unmeasured            a metric has no value for a trace: the rest of a report stands
    └── SchemaError           a results file is not what this version reads
        └── NewerFormat       because a newer version wrote it

To catch all of them, catch `HarnessError`.
"""

from harness.text import one_line, print_visible

__all__ = [
    "AskedError",
    "ContractViolation",
    "HarnessError",
    "MissingSolid",
    "NewerFormat",
    "PluginError",
    "SchemaError",
    "SimulationDiverged",
    "StorageError",
    "Unmeasured",
    "UsageError",
    "one_line",
    "print_visible",
]


class HarnessError(Exception):
    """The base class of every error that this project raises on purpose."""


class UsageError(HarnessError):
    """The user's mistake. The message says in one line what was given, what is allowed and what to do next."""


class PluginError(HarnessError):
    """A plugin cannot be imported, or registers something that it does not contain."""


class MissingSolid(HarnessError):
    """A simulator has left out a collision shape of an arm, so the arm would pass through the ground."""


class SimulationDiverged(HarnessError):
    """A simulator, a reward or a learner came to a number that is not finite."""


class ContractViolation(HarnessError):
    """A plugin breaks its interface's contract.

    Attributes:
        check: Name of the check that failed.
        level: ``error``; or ``warning`` if the contract is kept, but something is slow or was not tried.
        sentence: What is wrong, without the name of the check.
    """

    def __init__(self, check: str, message: str, level: str = "error") -> None:
        super().__init__(f"{check}: {message}")
        self.check, self.level, self.sentence = check, level, message


class AskedError(UsageError):
    """A file can be read in several ways, and so can those beside it: the message asks which is meant."""


class SchemaError(HarnessError):
    """A results file is damaged, or written by a newer version than this one."""


class NewerFormat(SchemaError):
    """A newer version than this one wrote the file. The file is not damaged, so nothing may replace it."""


class StorageError(HarnessError):
    """A results folder cannot be written: the disk is full or fails, or too many files are open."""


class Unscored(HarnessError):
    """A reward is not installed any more, has changed, or cannot pay these runs."""


class Unmeasured(HarnessError):
    """A metric raises an exception, is broken, or returns something that is not a finite number."""


def reason_of(error: BaseException) -> str:
    """The reason to show for an exception: the message of our own errors; of other errors the type and the message."""
    return str(error) if isinstance(error, HarnessError) else one_line(error)


def sentence(noun: str) -> str:
    """`noun` with a capital, to begin a message with; a path in it keeps its own capitals."""
    return noun[:1].upper() + noun[1:]
