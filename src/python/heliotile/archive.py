"""Archives: open one and compute irradiance from it."""

from __future__ import annotations

import html
import os
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING, Any, Unpack

import numpy as np

from . import _heliotile
from .askable import Askable
from .errors import InputError, wrong
from .given import WantedArgs, asked, wanted_args
from .options import AuditOptions, ExportOptions, ExtractOptions, UpdateOptions, ViewOptions, Wanted

if TYPE_CHECKING:
    from .checks import AuditReport, CheckedArchive, UpdateDone
    from .scene import BuildReport


class Archive(Askable):
    """A site that was traced once. Replay any weather, or query any sun and sky. Several threads
    may use one archive; it pickles by its path.

    `Archive.open("site.helio")` opens one, and so does `Archive("site.helio")`.
    """

    def __init__(
        self,
        handle: _heliotile.ArchiveHandle | str | os.PathLike[str],
        path: str | None = None,
        access: str = "map",
        grid_north: bool = False,
    ) -> None:
        if isinstance(handle, (str, os.PathLike)):
            path = os.fspath(handle)
            handle = _heliotile.ArchiveHandle.open(path, access, grid_north)
        if path is None:
            raise TypeError("Archive needs the path of an archive: Archive.open(\"site.helio\")")
        self._handle = handle
        self._known: dict[str, np.ndarray] | None = None
        self.path, self.access, self.grid_north = path, access, grid_north
        self.built: BuildReport | None = None
        """Report of the build, if `build` returned this archive."""
        self.updated: UpdateDone | None = None
        """Report of the update, if `update` returned this archive."""

    @classmethod
    def open(cls, path: str | os.PathLike[str], *, access: str = "map", grid_north: bool = False) -> Archive:
        """Opens a finished archive.

        `access` is `"map"`, or `"pread"` for files that other programs may shorten and for network
        file systems. `grid_north` uses y as north and ignores the true north of the archive.
        """
        path = os.fspath(path)
        return cls(_heliotile.ArchiveHandle.open(path, access, grid_north), path, access, grid_north)

    def __enter__(self) -> Archive:
        return self

    def __exit__(self, *_: object) -> None:
        """Does nothing: the file is closed with the last reference, and nothing has to be
        written."""

    @property
    def root(self) -> str:
        """Hash of the archive's content."""
        return self._handle.root

    def extract(self, output: str | os.PathLike[str], receivers: Wanted | None = None, **options: Unpack[ExtractOptions]) -> Archive:
        """Writes an archive of some receivers, selected as in `replay`, and opens it: `heliotile
        extract`, byte by byte. With `replay_only`, `receivers` may be left out for all. The options are those of `heliotile.options.ExtractOptions`."""
        keywords = asked("Archive.extract", ExtractOptions, options, output=output)
        handle = self._handle.extract(keywords.args(), wanted_args(receivers), options.get("progress"))
        return Archive(handle, os.fspath(output))

    def audit(self, scene: Any, **options: Unpack[AuditOptions]) -> AuditReport:
        """Compares the archive's errors with its stated accuracy, by the independent reference path
        tracer: `heliotile archive audit`, value by value.

        `scene`: the `Scene` of the archive, or its files. `weather`, or a table of `conditions`;
        default: suns from all sides. The other options are those of
        `heliotile.options.AuditOptions`.
        """
        from . import checks

        keywords = asked("Archive.audit", AuditOptions, options, archive=self.path, **checks.original_scene(scene))
        return checks.audit(keywords, options.get("progress"))

    def update(self, output: str | os.PathLike[str], **options: Unpack[UpdateOptions]) -> Archive:
        """Edits the scene that the archive holds and opens the archive of the edited scene:
        `heliotile update`, byte by byte. Its `updated` counts the receivers that were kept, moved or
        removed. Only what an edit can alter is traced again.

        `add`: a `Scene` or scene files whose objects are added, in the coordinates of the scene.
        `move={"tower": (0, 0, 3)}`, `height={"tower": "+3m"}` and `material={"tower": "brick"}` by
        object or building. The options are those of `heliotile.options.UpdateOptions`.
        """
        from . import checks
        from .scene import Scene

        said: dict[str, Any] = dict(options)
        if isinstance(scene := options.get("add"), Scene):
            said = {**scene.options, **said, "add": scene.files}
            if of_files := [name for name in said if name in scene.options and name not in UpdateOptions.__optional_keys__]:
                raise wrong("add", f"states {', '.join(of_files)}, which an update does not take", "give a scene of files that state their heights")
        keywords = asked("Archive.update", UpdateOptions, said, before=self.path, output=output)
        path, done = checks.update(keywords, options.get("progress"))
        archive = Archive.open(path)
        archive.updated = done
        return archive

    def verify(self, *, deep: bool = False) -> CheckedArchive:
        """Checks every block: `heliotile archive verify`, finding by finding. `heliotile.verify` also takes
        a path that does not open."""
        from . import checks

        return checks.verify(self.path, deep=deep)[0]

    def export(self, output: str | os.PathLike[str], receiver: str | None = None, **options: Unpack[ExportOptions]) -> None:
        """Writes the layers of a receiver, as values (`.exr`) or as a picture (`.png`), or without
        a receiver a table of all view factors: `heliotile export`.

        `sun`: azimuth, clockwise from true north, and altitude in degrees, with `dni` and `dhi` in
        W/m2. Values include its light, a picture marks its position, and `panel` makes six pictures
        of its light paths. The options are those of `heliotile.options.ExportOptions`.
        """
        keywords = asked("Archive.export", ExportOptions, options, archive=self.path, output=output, access=self.access, receiver=receiver)
        _heliotile.export(keywords.add(view_factors=receiver is None).args())

    def view(self, output: str | os.PathLike[str], **options: Unpack[ViewOptions]) -> None:
        """Writes a page that shows the archive in a browser, also from a disk: `heliotile export
        --html`, byte by byte.

        The page contains an archive of up to 50 MB, and the weather, if given. For a larger archive
        it asks for the file. `with_` is an archive of the same site after a change: the page then
        shows before, after and the change.
        """
        after = options.get("with_")
        said = {**options, "with_": after.path if isinstance(after, Archive) else after}
        _heliotile.view(asked("Archive.view", ViewOptions, said, archive=self.path).args(), os.fspath(output), self.access)

    def show(self, height: int = 640, **options: Unpack[ViewOptions]) -> Page:
        """Returns the page of `view` for the output of a notebook's cell: `site.show(weather=
        "x.epw")` as the last line shows the site there, to turn and to click. `height` is that of
        the output in pixels. The page is part of the notebook, and works without a kernel, too."""
        with tempfile.TemporaryDirectory() as folder:
            page = Path(folder) / "page.html"
            self.view(page, **options)
            return Page(page.read_text(encoding="utf-8"), height)

    def _open(self, wanted: WantedArgs) -> _heliotile.ArchiveHandle:
        return self._handle

    def _table(self, opened: _heliotile.ArchiveHandle, wanted: WantedArgs, memory: int) -> dict[str, np.ndarray]:
        # The table of all receivers is kept, since it is used often.
        if wanted is not None:
            return super()._table(opened, wanted, memory)
        if self._known is None:
            self._known = super()._table(opened, None, memory)
        return dict(self._known)

    def __reduce__(self) -> tuple[Any, ...]:
        return _reopen, (type(self), absolute(self.path), self.access, self.grid_north, self.root)

    def __repr__(self) -> str:
        return f"Archive({_heliotile.shown(self.path)!r}, {self.count} receivers in {self.tiles} tiles, root {self.root[:16]})"


class Page:
    """A page of a site, which notebooks show."""

    def __init__(self, text: str, height: int) -> None:
        self.text, self.height = text, height
        """The page as HTML, and its height in pixels."""

    def _repr_html_(self) -> str:
        return f'<iframe srcdoc="{html.escape(self.text)}" style="width: 100%; height: {self.height}px; border: 0" allowfullscreen></iframe>'

    def __repr__(self) -> str:
        return f"Page of {len(self.text) / 1e6:.1f} MB, which a notebook shows"


def absolute(path: str) -> str:
    """Returns a path for processes in other folders; a name without a file here, such as a URL,
    stays as it is."""
    return os.path.abspath(path) if os.path.exists(path) else path


def _reopen(cls: type[Archive], path: str, access: str, grid_north: bool, root: str) -> Archive:
    """Opens the archive of a pickle, if it has not changed."""
    archive = cls.open(path, access=access, grid_north=grid_north)
    if archive.root != root:
        raise InputError(f"{_heliotile.shown(path)}: is another archive than the one that was pickled\n  to fix: open the archive again and pickle the new object")
    return archive
