"""A Sphinx extension: the library's plain docstrings, made readable for Sphinx.

In the source, parameters are aligned lines ``name:  text`` and formulas are plain text.  On the page, two or more such lines in a row
become a list, and the signs of a formula that Sphinx would take for markup are protected from it.
"""

import re

ITEM = re.compile(r"(\w[\w, ]*):\s+(\S.*)")
MEANT = re.compile(r"(``.*?``|`.*?`|(?<![\w*])\*{1,2}\w[^*]*\*{1,2}(?![\w*])|^ *\* )", re.S | re.M)  # code, emphasis, bullets
SIGN = re.compile(r"[|*]|(?<=\w)_(?!\w)")


def setup(app):
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", _rewrite)
    return {"parallel_read_safe": True}


def _rewrite(app, kind, name, thing, options, lines):
    paragraphs = re.split(r"\n\s*\n", escaped("\n".join(lines)))
    lines[:] = "\n\n".join(listed(paragraph) for paragraph in paragraphs).split("\n")


def escaped(text):
    """The text with a backslash before bars, stars and trailing underscores that stand outside of code, emphasis and bullets."""
    return "".join(part if i % 2 else SIGN.sub(r"\\\g<0>", part) for i, part in enumerate(MEANT.split(text)))


def listed(paragraph):
    """A paragraph of ``name: text`` lines with indented continuations, as an RST list; any other paragraph as it is."""
    lines = paragraph.split("\n")
    items = [ITEM.fullmatch(line) for line in lines]
    continued = all(item or line.startswith("  ") for item, line in zip(items, lines))
    if not items[0] or sum(map(bool, items)) < 2 or not continued:
        return paragraph
    return "\n".join(f"* ``{item[1]}``: {item[2]}" if item else f"  {line.strip()}" for item, line in zip(items, lines))
