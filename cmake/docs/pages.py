#!/usr/bin/env python3
"""Makes pages for Doxygen of the Markdown pages of the repository: pages.py SOURCE_DIR PAGES_DIR HTML_DIR

The pages are written for a reader of the repository. What Doxygen needs beyond that is added here: every page and heading
gets a label and every link the label that it leads to, pictures are found, and files of the repository that are no pages
are copied beside the HTML, so that links to them lead there. Fails on a link that leads nowhere.
"""
import os
import pathlib
import re
import shutil
import sys

# In the order of the site. What is indented is a page below the one before.
PAGES = """
include/hfh/pages/index.md
include/hfh/pages/concepts.md
examples/tutorial/README.md
include/hfh/pages/recipes.md
    examples/recipes/README.md
include/hfh/pages/hosts.md
include/hfh/pages/accuracy_and_speed.md
include/hfh/pages/safety.md
include/hfh/pages/faq.md
include/hfh/README.md
include/hfh/pages/more.md
    README.md
    examples/touch_terrain/README.md
    examples/viewer/README.md
    examples/large_terrain/README.md
    examples/c_api/README.md
    examples/chai3d/README.md
    examples/microcontroller/README.md
    examples/phantom/README.md
    examples/polled/README.md
    examples/data/README.md
    bench/README.md
    bench/results/README.md
    bench/results/accuracy.md
    bench/results/certify.md
    bench/results/closed_loop.md
    bench/results/fuzzing.md
    bench/results/goals.md
    bench/results/large_terrain.md
    bench/results/parts.md
    bench/results/updates.md
    bench/results/viewer.md
    .github/CHANGELOG.md
    .github/CONTRIBUTING.md
    .github/SECURITY.md
"""

LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")


def label_of(path):
    """The label of a page: letters, digits and _ only."""
    return "page_" + re.sub(r"\W+", "_", path.removesuffix(".md")).strip("_").lower()


def slug_of(heading):
    """The anchor that GitHub gives a heading."""
    text = re.sub(r"[^\w\- ]", "", re.sub(r"[`*]", "", heading).strip().lower())
    return text.replace(" ", "-")


class Page:
    def __init__(self, source, path):
        self.path = path
        self.label = label_of(path)
        self.text = (source / path).read_text(encoding="utf-8")
        self.anchors = {}
        self.title = None
        for line in outside_code(self.text):
            if heading := re.match(r"(#+) (.*)", line):
                self.title = self.title or heading[2]
                slug = slug_of(heading[2])
                # Doxygen's labels have no room for other letters; the number keeps them apart.
                self.anchors[slug] = f"{self.label}_{len(self.anchors)}"
        self.title = self.title or pathlib.Path(path).stem


def outside_code(text):
    """The lines that are not in a fenced block."""
    inside = False
    for line in text.split("\n"):
        if line.lstrip().startswith("```"):
            inside = not inside
        elif not inside:
            yield line


def arrows(block):
    """A Mermaid flow chart in words, for Doxygen draws none."""
    after = {}
    for source, target in re.findall(r"(\w+) --> (\w+)", block):
        after.setdefault(source, []).append(target)
    return "\n".join(f"- {source} → {', '.join(targets)}" for source, targets in after.items())


class Site:
    def __init__(self, source, pictures, html):
        self.source, self.pictures, self.html = source, pictures, html
        self.pages = {line.strip(): Page(source, line.strip()) for line in PAGES.split("\n") if line.strip()}
        self.parents = {}
        above = []
        for line in filter(str.strip, PAGES.split("\n")):
            depth = (len(line) - len(line.lstrip())) // 4
            above = above[:depth] + [line.strip()]
            if depth > 0:
                self.parents[line.strip()] = above[depth - 1]
        self.faults = []
        self.below = set()  # pages that stand below another one already

    def link(self, page, match):
        picture, text, target = match.groups()
        text = text.replace("`", "")  # Doxygen would show the marks
        if re.match(r"[a-z]+:", target):
            return match[0]
        name, _, anchor = target.partition("#")
        path = os.path.normpath(os.path.join(os.path.dirname(page.path), name)) if name else page.path
        if picture:
            name = path.replace("/", "_")
            return self.copied(page, path, self.pictures / name, f"![{text}]({name})", target)
        if path in self.pages:
            other = self.pages[path]
            if anchor:
                if anchor not in other.anchors:
                    self.faults.append(f"{page.path}: no heading for {target}")
                    return text
                return f"[{text}](@ref {other.anchors[anchor]})"
            if self.parents.get(path) == page.path and path not in self.below:
                self.below.add(path)
                return f'@subpage {other.label} "{text}"'
            return f"[{text}](@ref {other.label})"
        if (self.source / path).is_dir():
            return text
        return self.copied(page, path, self.html / "files" / path, f'<a href="files/{path}">{text}</a>', target)

    def copied(self, page, path, copy, result, target):
        if not (self.source / path).is_file():
            self.faults.append(f"{page.path}: no file for {target}")
            return result
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(self.source / path, copy)
        return result

    def rewritten(self, page):
        lines, block, titled = [], None, False
        for line in page.text.split("\n"):
            if block is not None:
                block.append(line)
                if line.lstrip().startswith("```"):
                    text = "\n".join(block)
                    lines.append(arrows(text) if "```mermaid" in text else text.replace("```cpp", "```{.cpp}"))
                    block = None
            elif line.lstrip().startswith("```"):
                block = [line]
            elif heading := re.match(r"(#+) (.*)", line):
                label = page.anchors[slug_of(heading[2])] if titled else page.label
                text = LINK.sub(lambda m: m[2], heading[2])
                lines.append(f"{heading[1]} {text} {{#{label}}}")
                titled = True
            else:
                lines.append(LINK.sub(lambda m: self.link(page, m), line))
        text = "\n".join(lines)
        if not titled:
            text = f"# {page.title} {{#{page.label}}}\n\n{text}"
        return text


def main():
    source, pages, html = (pathlib.Path(a) for a in sys.argv[1:4])
    for folder in (pages, html):
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
    site = Site(source, pages / "pictures", html)
    for number, page in enumerate(site.pages.values()):
        (pages / f"{number:02}_{page.label}.md").write_text(site.rewritten(page), encoding="utf-8")
    for path, parent in site.parents.items():
        if path not in site.below:
            site.faults.append(f"{parent} has no link to {path}, which stands below it")
    if site.faults:
        sys.exit("\n".join(site.faults))


main()
