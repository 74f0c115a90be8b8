#!/usr/bin/env python3
"""Whether every link of a folder of HTML pages leads somewhere in it: check_links.py HTML_DIR. Links to other sites are
counted and not followed."""
import html.parser
import pathlib
import sys
import urllib.parse


class Links(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.names, self.targets = set(), []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.names.update(values[key] for key in ("id", "name") if values.get(key))
        self.targets += [values[key] for key in ("href", "src", "data") if values.get(key)]


def main():
    root = pathlib.Path(sys.argv[1]).resolve()
    pages = {path: Links(path.read_text(encoding="utf-8")) for path in sorted(root.rglob("*.html"))}
    checked, away, faults = 0, set(), set()
    for path, page in pages.items():
        for target in page.targets:
            parts = urllib.parse.urlsplit(target)
            # Doxygen links to a list of nested classes also where all of them are private and there is no list.
            if parts.scheme == "javascript" or target == "#nested-classes":
                continue
            if parts.scheme or parts.netloc:
                away.add(target)
                continue
            checked += 1
            there = (path.parent / urllib.parse.unquote(parts.path)).resolve() if parts.path else path
            name = urllib.parse.unquote(parts.fragment)
            if not there.exists():
                faults.add(f"{path.name}: {target}: no such file")
            elif name and there in pages and name not in pages[there].names:
                faults.add(f"{path.name}: {target}: no such place")
    print(f"{len(pages)} pages, {checked} links within them, {len(faults)} of them dead; {len(away)} other addresses")
    for fault in sorted(faults):
        print(fault)
    sys.exit(bool(faults) or not pages)


main()
