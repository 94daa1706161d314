#!/usr/bin/env python3
"""Sentences of pages end within 45 words, and comments begin with their subject, not with Of, By,
As, What or Whether (CONTRIBUTING.md#style).

    plain_english.py ROOT

A sentence is prose of a page's paragraph or list item: tables, code and headings are left out.
Foreign files are left out too.
"""

import pathlib
import re
import subprocess
import sys

WORDS = 45
COMMENT = re.compile(r"(?:^|\s)(?:///?<?|//!|#|/\*\*?|\*) (?:Of|By|As|What|Whether) ")
END = re.compile(r"(?<=[.!?])[)*\"]*\s+(?=[*(\[\"`]*[A-Z0-9`])")
ABBREVIATION = re.compile(r"\b(e\.g|i\.e|Eq|Eqs|Fig|al)\. ")
CODE = (".c", ".h", ".cpp", ".hpp", ".proto", ".py", ".sh", ".ts", ".mjs", ".cs", ".awk", ".cmake")
FOREIGN = ("proto/google/", "proto/grpc/")


def paragraphs(text: str) -> list[tuple[int, str]]:
    """(line, text) of every paragraph and list item."""
    found: list[tuple[int, list[str]]] = []
    open_, in_code = False, False
    for number, line in enumerate(text.splitlines(), 1):
        words = line.strip()
        if words.startswith("```"):
            in_code = not in_code
        item = re.match(r"\s*(?:[-*]|\d+\.)\s+", line)
        code = line.startswith("    ") and not open_ and not item
        if in_code or code or not words or words.startswith(("| ", "|-", "#", "```", "---")):
            open_ = False
        elif item or not open_:
            found.append((number, [line[item.end() :] if item else words]))
            open_ = True
        else:
            found[-1][1].append(words)
    return [(number, " ".join(lines)) for number, lines in found]


def long_sentences(text: str) -> list[tuple[int, int]]:
    """(line of the paragraph, words) of every sentence that is too long."""
    found = []
    for number, paragraph in paragraphs(text):
        prose = re.sub(r"\]\([^)]*\)", "]", re.sub(r"`[^`]*`", "Code", paragraph))
        if " · " in prose:  # a list of links
            continue
        for sentence in END.split(ABBREVIATION.sub(r"\1 ", prose)):
            words = sum(any(c.isalnum() for c in word) for word in sentence.split())
            if words > WORDS:
                found.append((number, words))
    return found


def main() -> int:
    root = pathlib.Path(sys.argv[1]).resolve()
    listed = subprocess.run(
        ["sh", "-c", '. "$0" && files_of "$1"', pathlib.Path(__file__).parent / "files.sh", root],
        capture_output=True,
        text=True,
        check=True,
    ).stdout.split()
    wrong, checked = [], 0
    for file in sorted(listed):
        name = pathlib.PurePath(file).name
        page = file.endswith(".md")
        if file.startswith(FOREIGN) or not (root / file).is_file():
            continue
        if not page and not file.endswith(CODE) and name != "CMakeLists.txt":
            continue
        checked += 1
        text = (root / file).read_text(encoding="utf-8")
        if page:
            found = long_sentences(text)
            wrong += [f"{file}:{number}: a sentence of {words} words" for number, words in found]
            continue
        for number, line in enumerate(text.splitlines(), 1):
            if COMMENT.search(line):
                wrong.append(f"{file}:{number}: a comment that hides its subject: {line.strip()}")
    print("\n".join(wrong) if wrong else f"{checked} files checked")
    return 1 if wrong else 0 if checked else 2


if __name__ == "__main__":
    sys.exit(main())
