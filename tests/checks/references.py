#!/usr/bin/env python3
"""Every reference leads somewhere. Checked, in all files of the repository:

  [text](path#section)   in Markdown outside code, the path relative to the page
  PAGE.md, #section      in any file, the page relative to the repository
  `folder/file.ext`      in the tables of README.md and core/*.md, relative to the repository, to
  the
                         page, or to core's headers and sources

A section is a heading, named as GitHub names it. METHOD, WIRE or HOUSE with a number is a page that
the repository does not have.

  references.py [ROOT]
"""
import pathlib
import re
import subprocess
import sys

LINK = re.compile(r"\]\(([^)\s]+)\)")
CITATION = re.compile(r"(?<![\w./-])([A-Za-z0-9_][\w./-]*\.md)#([\w-]+)")
TABLE_PATH = re.compile(
    r"`([\w.-]+/[\w./-]*\.(?:hpp|cpp|sh|py|proto|md|txt)|[\w.-]+(?:/[\w.-]+)*/)`"
)
BY_NUMBER = re.compile(r"\b(?:METHOD|WIRE|HOUSE) (?:section )?\d")
CORE = ("core/include/haptic/core", "core/src")


def files_of(root):
    git = ["git", "-C", str(root), "ls-files", "--cached", "--others", "--exclude-standard"]
    try:
        listed = subprocess.run(git, check=True, capture_output=True, text=True).stdout.split("\n")
    except (OSError, subprocess.CalledProcessError):
        skipped = ("build/", ".git/", "demo-output/", "report/")
        every = (str(path.relative_to(root)) for path in root.rglob("*") if path.is_file())
        listed = [path for path in every if not path.startswith(skipped)]
    return sorted(path for path in listed if path and (root / path).is_file())


def without_blocks(text):
    return re.sub(r"^ *```.*?^ *```", "", text, flags=re.M | re.S)


def sections_of(page):
    """The anchors of a page's headings, repeated ones numbered."""
    seen = {}
    for heading in re.findall(r"^#+ +(.+?) *$", without_blocks(page.read_text()), re.M):
        slug = re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-")
        seen[slug] = seen.get(slug, -1) + 1
        yield slug if seen[slug] == 0 else f"{slug}-{seen[slug]}"


def main(root):
    known, wrong, checked = {}, [], 0

    def look(file, target, section, bases):
        nonlocal checked
        checked += 1
        found = [root / base / target for base in bases if (root / base / target).exists()]
        if not found:
            wrong.append(f"{file}: no such file: {target}")
        elif section and not re.match(r"L\d", section):
            page = found[0].resolve()
            if section not in known.setdefault(page, set(sections_of(page))):
                wrong.append(f"{file}: no such section: {target}#{section}")

    for file in files_of(root):
        try:
            text = (root / file).read_text()
        except UnicodeDecodeError:
            continue
        folder = pathlib.PurePath(file).parent
        if file.endswith(".md"):
            for link in LINK.findall(re.sub(r"`[^`]*`", "", without_blocks(text))):
                if not re.match(r"[a-z]+:", link):
                    target, _, section = link.partition("#")
                    look(file, target or pathlib.PurePath(file).name, section, [folder])
        links = re.sub(LINK, "", text) if file.endswith(".md") else text
        for target, section in CITATION.findall(links):
            look(file, target, section, ["."])
        if file == "README.md" or re.fullmatch(r"core/[A-Z]+\.md", file):
            for row in re.findall(r"^\|.*", text, re.M):
                for target in TABLE_PATH.findall(row):
                    look(file, target, "", [".", folder, *CORE])
        for line in BY_NUMBER.findall(text):
            wrong.append(f"{file}: a page that is not here: {line}")
    print("\n".join([*wrong, f"{checked} references checked"]))
    return 1 if wrong else 0 if checked else 2


if __name__ == "__main__":
    here = pathlib.Path(__file__).resolve().parents[2]
    sys.exit(main(pathlib.Path(sys.argv[1]).resolve() if len(sys.argv) > 1 else here))
