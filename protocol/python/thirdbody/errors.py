"""Faults that a participant reports to the coordinator, each with the exit code of the run."""

from __future__ import annotations


class Fault(Exception):
    """The participant cannot go on."""

    code = "protocol"


class ConfigurationError(Fault):
    """The scenario or a request cannot be followed (exit code 2)."""

    code = "configuration"


class Diverged(Fault):
    """The solution became infinite or NaN, or a solver did not converge (exit code 3)."""

    code = "diverged"


class ProtocolError(Fault):
    """A frame arrived out of place (exit code 4)."""

    code = "protocol"


class OutputError(Fault):
    """A file cannot be written (exit code 9)."""

    code = "output"


def code_of(error: BaseException) -> str:
    """The code of any exception that ends a participant."""
    if isinstance(error, Fault):
        return error.code
    if isinstance(error, OSError):
        return "output"
    if isinstance(error, ArithmeticError) or type(error).__name__ == "LinAlgError":
        return "diverged"
    return "configuration"
