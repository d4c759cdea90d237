"""Exceptions and warnings. Texts are those of the program: what was found, in which file and line, and what to do."""

from __future__ import annotations

from pathlib import Path


class Error(Exception):
    """Whatever heliotile cannot do. Attributes that do not apply are None."""

    file: Path | None = None
    """The file, as it was named."""
    line: int | None = None
    """1-based line of the file; of a table that was given in memory, its first row is line 2."""
    what: str | None = None
    """What was found."""
    hint: str | None = None
    """What to do."""

    def __str__(self) -> str:
        # OSError would write an errno in front.
        return str(self.args[0]) if self.args else ""


class InputError(Error, ValueError):
    """A file, or a table that was given for one, holds something that cannot be used."""


class ArgumentError(Error, ValueError):
    """An argument has a value that cannot be used."""

    argument: str | None = None


class FileError(Error, OSError):
    """The operating system refused to read or to write."""


class MissingFileError(FileError, FileNotFoundError):
    """A file is not there."""


class CorruptError(Error):
    """Bytes of an archive are not those that were written."""

    block: str | None = None
    """Name of the block, such as `sky/3`."""
    offset: int | None = None
    """Where it starts in the file, bytes."""


class ChangedError(Error):
    """What is read is another file or object than when it was opened; nothing of both was mixed."""


class IncompleteError(Error):
    """An interrupted build of other inputs lies where an archive is to be written."""


class StoppedError(Error):
    """Work that was asked to stop."""


class UnsupportedError(Error, NotImplementedError):
    """The request is valid, but this release cannot do it."""


class LimitError(Error, OverflowError):
    """A number is beyond a stated limit."""


class HeliotileWarning(UserWarning):
    """What the program would print as a warning."""
