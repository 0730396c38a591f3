"""Exceptions of the engine and of its programs. Their text is the engine's own sentence."""


class Error(Exception):
    """Any error of the engine. `code` is the exit code that the programs have for it."""

    code = 1


class FileError(Error, OSError):
    """The system failed: a file that is missing or cannot be written, memory."""

    code = 1


class UsageError(Error, ValueError):
    """An unknown name, an argument that does not fit, a call that is not possible now."""

    code = 2


class ContentError(Error, ValueError):
    """A value, or the content of a file, is invalid."""

    code = 3


class SolverError(Error, ArithmeticError):
    """A solver gave up."""

    code = 4


class BoundError(Error, ArithmeticError):
    """The energy of a motion left its bound: the method has exploded."""

    code = 5


class CriterionError(Error):
    """A stated criterion was missed."""

    code = 6


_by_code = {kind.code: kind for kind in (
    UsageError, ContentError, SolverError, BoundError, CriterionError)}


def of_exit_code(code: int, message: str) -> Error:
    """The exception for a program that ended with `code`."""
    return _by_code.get(code, FileError)(message)
