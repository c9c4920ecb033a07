"""Every error that this project raises on purpose.

HarnessError
├── UsageError            what the user gave cannot be used: one line, exit status 2, nothing written
├── PluginError           a plugin is broken: names the plugin, its distribution and the target
├── SimulationDiverged    a simulation or a reward left the finite numbers: the cell fails, the plan goes on
├── ContractViolation     a plugin breaks its interface's contract: names the check
├── SchemaError           a results file is not what this version reads
└── Unscored              a reward cannot pay recorded runs again: the rest of a report stands
"""


class HarnessError(Exception):
    """Root of the tree: catching it catches whatever this project raises on purpose."""


class UsageError(HarnessError):
    """What was given, what is allowed, what to do next; in one line."""


class PluginError(HarnessError):
    """A plugin cannot be imported, or registers what it does not have."""


class SimulationDiverged(HarnessError):
    """A simulator or a reward returned a number that is not finite."""


class ContractViolation(HarnessError):
    """A simulator, reward or algorithm breaks its interface's contract.

    Attributes:
        check: Name of the check that failed.
    """

    def __init__(self, check: str, message: str) -> None:
        super().__init__(f"{check}: {message}")
        self.check = check


class SchemaError(HarnessError):
    """A results file is damaged, or written by a newer version than this one."""


class Unscored(HarnessError):
    """A reward is not installed any more, has changed, or cannot pay these runs."""


def one_line(error: BaseException) -> str:
    """The type and the message of an exception on one line, ``ValueError: no such thing``."""
    return f"{type(error).__name__}: {' '.join(str(error).split())}".removesuffix(": ")


def sentence(noun: str) -> str:
    """`noun` with a capital, to begin a message with; a path in it keeps its own capitals."""
    return noun[:1].upper() + noun[1:]
