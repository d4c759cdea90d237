"""Archives: open one, ask it for irradiance."""

from __future__ import annotations

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _heliotile
from .askable import Askable
from .options import MEMORY, Progress, Wanted, WantedArgs, wanted_args
from .errors import InputError

if TYPE_CHECKING:
    from .scene import BuildReport


class Archive(Askable):
    """A site that was traced once: replay any weather, ask for any sun and sky. Many threads may use one; it pickles by its path.

    Use `Archive.open`.
    """

    def __init__(self, handle: _heliotile.ArchiveHandle, path: str, access: str = "map", grid_north: bool = False) -> None:
        self._handle = handle
        self._known: dict[str, np.ndarray] | None = None
        self.path, self.access, self.grid_north = path, access, grid_north
        self.built: BuildReport | None = None
        """What was done, where `build` gave this archive."""

    @classmethod
    def open(cls, path: str | os.PathLike[str], *, access: str = "map", grid_north: bool = False) -> Archive:
        """Opens a finished archive.

        `access` is `"map"`, or `"pread"` for files that others may shorten and for network file systems. `grid_north` takes y for
        north, whatever the archive says of its place.
        """
        path = os.fspath(path)
        return cls(_heliotile.ArchiveHandle.open(path, access, grid_north), path, access, grid_north)

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, *_: object) -> None:
        """The file is closed with the last reference; nothing has to be written."""

    @property
    def root(self) -> str:
        """Hash of the archive's content."""
        return self._handle.root

    def extract(
        self,
        output: str | os.PathLike[str],
        receivers: Wanted,
        *,
        with_scene: bool = True,
        memory: int = MEMORY,
        progress: Progress | None = None,
    ) -> Archive:
        """Writes an archive of some receivers, named as in `replay`, and opens it: `heliotile extract`, byte by byte."""
        handle = self._handle.extract(os.fspath(output), wanted_args(receivers), with_scene, memory, progress)
        return Archive(handle, os.fspath(output))

    def _open(self, wanted: WantedArgs) -> _heliotile.ArchiveHandle:
        return self._handle

    def _table(self, opened: _heliotile.ArchiveHandle, wanted: WantedArgs, memory: int) -> dict[str, np.ndarray]:
        # That of all is asked for again and again.
        if wanted is not None:
            return super()._table(opened, wanted, memory)
        if self._known is None:
            self._known = super()._table(opened, None, memory)
        return dict(self._known)

    def __reduce__(self) -> tuple[Any, ...]:
        return _reopen, (type(self), absolute(self.path), self.access, self.grid_north, self.root)

    def __repr__(self) -> str:
        return f"Archive({_heliotile.shown(self.path)!r}, {self.count} receivers in {self.tiles} tiles, root {self.root[:16]})"


def absolute(path: str) -> str:
    """A path for processes that work elsewhere; what is no file here, such as a URL, stays as it is."""
    return os.path.abspath(path) if os.path.exists(path) else path


def _reopen(cls: type[Archive], path: str, access: str, grid_north: bool, root: str) -> Archive:
    """What a pickle becomes: the archive of that path, if it is still the same."""
    archive = cls.open(path, access=access, grid_north=grid_north)
    if archive.root != root:
        raise InputError(f"{_heliotile.shown(path)}: is another archive than the one that was pickled\n  to fix: open it again and pickle that")
    return archive
