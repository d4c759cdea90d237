"""Gathers the pages of the site from the repository. In: a folder to write into. Out: in it `book.toml` and `src` for mdBook: README, the book, the gallery,
the format and what else these link to, with links that fit the site.

The table of contents is that of the book's own first page, `src/book/README.md`.
"""
import os
import re
import shutil
import sys
from pathlib import Path

TOP = Path(__file__).resolve().parents[2]
GALLERY = "tools/examples"
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)")
BOOK_TOML = """[book]
title = "heliotile"
description = "Trace a site's sun and sky once, replay any weather"
language = "en"

[output.html]
default-theme = "light"
preferred-dark-theme = "navy"
additional-css = ["site.css"]

[output.html.search]
limit-results = 20
"""
CSS = """.gallery { display: grid; grid-template-columns: repeat(auto-fill, minmax(16rem, 1fr)); gap: 1.5rem; }
.gallery img { width: 100%; height: 10rem; object-fit: contain; background: #fff; }
table { overflow-x: auto; display: block; }
"""


def site_path(path):
    """Where a file of the repository stands on the site; None where it does not."""
    if path == "README.md":
        return "index.md"
    if path == "src/book/README.md":
        return "contents.md"
    if path == GALLERY:
        return "gallery.md"
    parts = path.split("/")
    if parts[:2] == ["src", "book"] and len(parts) == 3 and path.endswith(".md"):
        return parts[2]
    if parts[:3] == ["src", "book", "reference"] and path.endswith(".md"):
        return f"reference/{parts[3]}"
    if parts[0] == "schema" or path.startswith("tools/pictures/"):
        return path.removeprefix("tools/")
    if path.startswith(GALLERY + "/") and len(parts) == 4:
        return f"gallery/{parts[2]}.md" if parts[3] == "README.md" else f"gallery/{parts[2]}-{parts[3]}"
    return {"tools/README.md": "tools.md", "tests/data/SOURCES.md": "sources.md", "CHANGELOG.md": "changelog.md", "CONTRIBUTING.md": "contribute.md",
            "SECURITY.md": "security.md"}.get(path)


class Pages:
    def __init__(self, out):
        self.out, self.done = Path(out), set()

    def add(self, path):
        """A file and, if it is a page, what it links to."""
        if path in self.done or not (TOP / path).exists():
            return
        self.done.add(path)
        to = self.out / "src" / site_path(path)
        to.parent.mkdir(parents=True, exist_ok=True)
        if path == GALLERY:
            to.write_text(self.gallery())
        elif path.endswith(".md"):
            to.write_text(self.linked((TOP / path).read_text(), path))
        else:
            shutil.copy(TOP / path, to)

    def linked(self, text, path):
        """The text with links as they are on the site; what does not stand there is named without a link."""
        def link(found):
            picture, words, target = found.groups()
            if re.match(r"[a-z]+:|#", target):
                return found[0]
            file, _, part = target.partition("#")
            file = os.path.normpath(os.path.join(os.path.dirname(path), file))
            to = site_path(file)
            if to is None or not (TOP / file).exists():
                return words
            self.add(file)
            to = os.path.relpath(to, os.path.dirname(site_path(path)) or ".")
            return f"{picture}[{words}]({to}{'#' + part if part else ''})"

        # Blocks of commands and output stay as they are.
        parts = re.split(r"(?ms)(^```.*?^```$)", text)
        return "".join(part if part.startswith("```") else LINK.sub(link, part) for part in parts)

    def gallery(self):
        lines = ["# Gallery", "", "Each example has its data, its commands and what they draw. The first one is also [live](live/index.html).", "", '<div class="gallery">', ""]
        for folder in sorted((TOP / GALLERY).glob("*/README.md")):
            path = folder.relative_to(TOP).as_posix()
            self.add(path)
            title, picture = title_of(path), next(folder.parent.glob("picture.*")).name
            self.add(f"{GALLERY}/{folder.parent.name}/{picture}")
            name = f"gallery/{folder.parent.name}"
            lines.append(f'<div><a href="{name}.html"><img src="{name}-{picture}" alt="{title}"><br>{title}</a></div>')
        return "\n".join([*lines, "</div>", ""])

    def summary(self):
        """The chapters: README, the gallery, the tables of the book's first page, the format."""
        lines = ["# Summary", "", "[heliotile](index.md)", "[Gallery](gallery.md)", "[All pages](contents.md)", ""]
        for line in (TOP / "src/book/README.md").read_text().splitlines():
            if line.startswith("## "):
                lines += [f"# {line[3:]}", ""]
            elif found := re.match(r"\| \[([^\]]+)\]\(([^)]+)\)", line):
                lines.append(f"- [{found[1][0].upper() + found[1][1:]}]({found[2]})")
        listed = {line.split("](")[1].rstrip(")") for line in lines if "](" in line}
        more = {"Commands and their options": "reference/", "The format": "schema/", "Examples": "gallery/", "Project": ""}
        for part, start in more.items():
            pages = sorted((title_of(path), site_path(path)) for path in self.done if path.endswith(".md"))
            pages = [(title, to) for title, to in pages if to not in listed and to.startswith(start)]
            listed |= {to for _, to in pages}
            lines += ["", f"# {part}", ""] + [f"- [{title}]({to})" for title, to in pages]
        return "\n".join(lines) + "\n"


def title_of(path):
    """The heading of a page, without marks of code."""
    return next(line[2:] for line in (TOP / path).read_text().splitlines() if line.startswith("# ")).replace("`", "")


def main(out):
    shutil.rmtree(out, ignore_errors=True)
    pages = Pages(out)
    for path in ["README.md", "src/book/README.md", GALLERY, "CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md", *sorted(
            page.relative_to(TOP).as_posix() for folder in ("src/book", "src/book/reference", "schema") for page in (TOP / folder).glob("*.md"))]:
        pages.add(path)
    (pages.out / "src/SUMMARY.md").write_text(pages.summary())
    (pages.out / "book.toml").write_text(BOOK_TOML)
    (pages.out / "site.css").write_text(CSS)


main(*sys.argv[1:])
