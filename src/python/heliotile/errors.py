"""Exceptions and warnings. Each has the text of the program: what was found, in which file and
line, and what to do."""

from __future__ import annotations

from pathlib import Path


class Error(Exception):
    """Base class of heliotile's errors. Attributes that do not apply are None."""

    file: Path | None = None
    """File, by the name that was given."""
    line: int | None = None
    """1-based line of the file; the first row of a table in memory is line 2."""
    what: str | None = None
    """Problem that was found."""
    hint: str | None = None
    """Advice on what to do; empty if `what` says it."""
    problem: str | None = None
    """Kind of the problem: `missing`, `excludes`, `needs`, `unreadable`, `out-of-range`, `unknown`,
    `no-column`, `same-file`, `duplicate`, `value`, `lacks`, `empty`, `misplaced`, `ending`,
    `other-kind`, `other-version`, `other-inputs`, `other-site`, `exists`, `busy`, `damaged` or
    `other`."""
    found: float | str | None = None
    """Number, name, text, kind or version that was found."""
    name: str | None = None
    """Column or key of the value, of `value`; what the file lacks, of `lacks`."""
    range: tuple[float, float] | None = None
    """Smallest and largest number allowed, of `out-of-range`."""
    known: list[str] | None = None
    """Known names, of `unknown`."""
    column: str | None = None
    """Column that a table lacks, of `no-column`."""
    other: str | list[str] | Path | None = None
    """The other keyword, of `excludes`; keywords, of `needs`; the other file, of `same-file`."""

    def __str__(self) -> str:
        # OSError would put an errno before the text.
        return str(self.args[0]) if self.args else ""


class InputError(Error, ValueError):
    """A file, or a table given in its place, holds something that cannot be used."""


class ArgumentError(Error, ValueError):
    """An argument has a value that cannot be used."""

    argument: str | None = None


class FileError(Error, OSError):
    """The operating system refused to read or to write."""


class MissingFileError(FileError, FileNotFoundError):
    """A file does not exist."""


class CorruptError(Error):
    """Bytes of an archive differ from those that were written."""

    block: str | None = None
    """Name of the block, such as `sky/3`."""
    offset: int | None = None
    """Start of the block in the file, bytes."""


class ChangedError(Error):
    """A file or object has changed since it was opened. Old and new bytes were not mixed."""


class IncompleteError(Error):
    """An interrupted build of other inputs exists where an archive is to be written."""


class StoppedError(Error):
    """Work was stopped on request."""


class UnsupportedError(Error, NotImplementedError):
    """The request is valid, but this release cannot do it."""


class LimitError(Error, OverflowError):
    """A number exceeds a stated limit."""


class HeliotileWarning(UserWarning):
    """Warning that the program would print."""


def wrong(argument: str, what: str, hint: str) -> ArgumentError:
    """Returns an error about an argument, in the usual form."""
    error = ArgumentError(f"{argument}: {what}\n  to fix: {hint}")
    error.argument, error.what, error.hint = argument, what, hint
    return error
