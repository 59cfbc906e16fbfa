#!/usr/bin/env python3
"""Preprocessor of mdBook: links to files that are no pages of the site lead to the repository.

A relative link stays as it is if its target is a page of docs/, or an image in it. Every other file and every folder is linked
by its address in the repository, which book.toml names.
"""

import json
import os
import re
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
ROOT = DOCS.parent
IMAGES = {".jpg", ".png", ".svg", ".webp"}
LINK = re.compile(r"\]\(([^)#\s]+)(#[^)\s]*)?\)")


def address(target: str, page: Path, repository: str) -> str:
    """What a link from a page leads to."""
    if "://" in target or target.startswith("mailto:"):
        return target
    path = Path(os.path.normpath(page.parent / target))
    is_in_site = path.is_relative_to(DOCS) and (path.suffix == ".md" or path.suffix in IMAGES)
    if not is_in_site:
        kind = "tree" if path.is_dir() else "blob"
        return f"{repository}/{kind}/main/{path.relative_to(ROOT).as_posix()}"
    # A page README.md becomes index.html.
    return re.sub(r"README\.md$", "index.md", target)


def rewrite(item: dict, repository: str) -> None:
    """The links of a chapter and of those below it."""
    chapter = item.get("Chapter") if isinstance(item, dict) else None
    if chapter is None:
        return
    if chapter.get("source_path"):
        page = DOCS / chapter["source_path"]
        chapter["content"] = LINK.sub(
            lambda found: f"]({address(found[1], page, repository)}{found[2] or ''})", chapter["content"]
        )
    for below in chapter["sub_items"]:
        rewrite(below, repository)


def main() -> int:
    if sys.argv[1:2] == ["supports"]:
        return 0
    context, book = json.load(sys.stdin)
    repository = context["config"]["output"]["html"]["git-repository-url"]
    for item in book.get("items", book.get("sections", [])):
        rewrite(item, repository)
    json.dump(book, sys.stdout)
    return 0


if __name__ == "__main__":
    sys.exit(main())
