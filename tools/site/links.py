"""Checks the links of a folder of web pages. In: the folder. Out: how many pages and links it has; exit code 1 and a line for each link to a file, or to a
place of a page, that does not exist. Addresses elsewhere are not asked."""
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit


class Page(HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.places, self.links = {"", "top"}, []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        for name, value in attributes:
            if name in ("id", "name") and value:
                self.places.add(value)
            elif name in ("href", "src") and value:
                self.links.append(value)


def main(folder):
    folder = Path(folder).resolve()
    pages = {path: Page(path.read_text()) for path in sorted(folder.rglob("*.html")) if path.name not in ("toc.html", "404.html", "print.html")}
    count, broken = 0, []
    for path, page in pages.items():
        # A page of its own, which loads what it needs.
        if "live" in path.relative_to(folder).parts:
            continue
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            count += 1
            to = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            to = to / "index.html" if to.is_dir() else to
            known = pages.get(to)
            if not to.is_file() or (known and unquote(parts.fragment) not in known.places):
                broken.append(f"{path.relative_to(folder)}: {link}")
    print(f"{len(pages)} pages, {count} links, {len(broken)} broken", *broken, sep="\n")
    return 1 if broken else 0


sys.exit(main(*sys.argv[1:]))
