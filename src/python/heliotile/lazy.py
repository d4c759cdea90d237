"""A replay that computes tiles on demand. In: an archive, arguments of a replay. Out: rows; it
pickles."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np

from . import _heliotile
from .archive import Archive
from .given import Asked
from .results import Frame
from .workers import share_threads

#: Number of receivers whose rows are in memory at once, besides the requested ones.
AT_ONCE = 1024


class LazyReplay:
    """Rows of a replay by receiver. Threads may share it; a pickle opens the archive again."""

    def __init__(self, archive: Archive, keywords: Asked, cache: int) -> None:
        self._made_of = (archive, keywords, cache)
        self._lock = threading.Lock()
        self._handle: _heliotile.LazyReplay | None = None

    @property
    def handle(self) -> _heliotile.LazyReplay:
        """The engine's replay, created when it is first used."""
        with self._lock:
            if self._handle is None:
                share_threads()
                archive, keywords, cache = self._made_of
                self._handle = archive._handle.lazy(keywords.args(), cache)
            return self._handle

    @property
    def frame(self) -> Frame:
        """Number of receivers, labels and columns."""
        return Frame(self.handle.frame())

    def rows(self, column: str, receivers: np.ndarray, labels: Any) -> np.ndarray:
        """Returns values of a column, float32, shape `(receivers, labels)`: receivers by number,
        labels by a slice or by numbers."""
        order = np.argsort(receivers, kind="stable")
        found: np.ndarray | None = None
        for first in range(0, len(order), AT_ONCE):
            some = order[first : first + AT_ONCE]
            values = np.asarray(self.handle.rows(column, receivers[some].tolist()))[:, labels]
            if found is None:
                found = np.empty((len(receivers), values.shape[1]), dtype=np.float32)
            found[some] = values
        if found is None:
            count = len(np.arange(len(self.frame.labels))[labels])
            found = np.empty((0, count), dtype=np.float32)
        return found

    def __getstate__(self) -> tuple[Any, ...]:
        archive, keywords, cache = self._made_of
        return archive, keywords.absolute(), cache

    def __setstate__(self, state: tuple[Any, ...]) -> None:
        self.__init__(*state)
