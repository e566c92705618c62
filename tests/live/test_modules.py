"""No module of a live figure holds what another has, or what nobody takes."""

import re

from mkt.figures.live import COMMENT, EXPORT, IMPORT, MODULES

TEXTS = {path.stem: path.read_text("utf-8") for path in MODULES.glob("*.js")}
TAKEN_BY_ANYWIDGET = {("widget", "initialize"), ("widget", "render")}
CONSTANT = re.compile(
    r"^(?:export )?const ((?:[A-Z_]+ =|\w+ = .*=>).*?;)", re.MULTILINE
)


def test_what_a_module_exports_is_taken_by_another():
    exported = {
        (module, name)
        for module, text in TEXTS.items()
        for _, name in EXPORT.findall(text)
    }
    taken = {
        (module, name)
        for text in TEXTS.values()
        for names, module in IMPORT.findall(text)
        for name in re.findall(r"\w+", names)
    }
    assert exported == taken | TAKEN_BY_ANYWIDGET


def test_what_a_module_takes_it_needs():
    for text in TEXTS.values():
        code = COMMENT.sub("", IMPORT.sub("", text))
        for names, _ in IMPORT.findall(text):
            for name in re.findall(r"\w+", names):
                assert re.search(rf"\b{name}\b", code)


def test_no_constant_stands_in_two_modules():
    found = [line for text in TEXTS.values() for line in set(CONSTANT.findall(text))]
    assert sorted(found) == sorted(set(found))
