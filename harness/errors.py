"""Every error that this project raises on purpose.

::

    HarnessError
    ├── UsageError            what the user gave cannot be used: one line, exit status 2, nothing written
    ├── PluginError           a plugin is broken: names the plugin, its distribution and the target
    ├── SimulationDiverged    a simulation or a reward left the finite numbers: the cell fails, the plan goes on
    ├── ContractViolation     a plugin breaks its interface's contract: names the check
    ├── StorageError          a results folder cannot be written: the disk is full, or fails; what was done stays
    ├── Unscored              a reward cannot pay recorded runs again: the rest of a report stands
    ├── Unmeasured            a metric cannot say anything of a trace: the rest of a report stands
    └── SchemaError           a results file is not what this version reads
        └── NewerFormat       because a newer version wrote it

Who catches `HarnessError` catches them all.
"""

from harness.text import one_line_of


class HarnessError(Exception):
    """Root of the tree: catching it catches whatever this project raises on purpose."""


class UsageError(HarnessError):
    """What was given, what is allowed, what to do next; in one line."""


class PluginError(HarnessError):
    """A plugin cannot be imported, or registers what it does not have."""


class SimulationDiverged(HarnessError):
    """A simulator or a reward returned a number that is not finite."""


class ContractViolation(HarnessError):
    """A plugin breaks its interface's contract.

    Attributes:
        check: Name of the check that failed.
        level: ``error``; ``warning`` where the contract is kept, but something is slow or was not tried.
        sentence: What is wrong, without the name of the check.
    """

    def __init__(self, check: str, message: str, level: str = "error") -> None:
        super().__init__(f"{check}: {message}")
        self.check, self.level, self.sentence = check, level, message


class SchemaError(HarnessError):
    """A results file is damaged, or written by a newer version than this one."""


class NewerFormat(SchemaError):
    """A newer version than this one wrote the file: nothing is wrong with it, and nothing may replace it."""


class StorageError(HarnessError):
    """A results folder cannot be written: the disk is full or fails, or too many files are open."""


class Unscored(HarnessError):
    """A reward is not installed any more, has changed, or cannot pay these runs."""


class Unmeasured(HarnessError):
    """A metric raises, is broken, or returns what is no finite number."""


def one_line(error: BaseException) -> str:
    """The type and the message of an exception on one line, ``ValueError: no such thing``; see `one_line_of`."""
    return one_line_of(f"{type(error).__name__}: {error}").removesuffix(":")


def reason_of(error: BaseException) -> str:
    """What to say of an exception that costs its own row: our errors say it all, of others the type stands first."""
    return str(error) if isinstance(error, HarnessError) else one_line(error)


def sentence(noun: str) -> str:
    """`noun` with a capital, to begin a message with; a path in it keeps its own capitals."""
    return noun[:1].upper() + noun[1:]
