"""No module of a live figure holds what another has, or what nobody takes."""

import re

from mkt.figures.live import COMMENT, EXPORT, IMPORT, MODULES, imports, source

PATHS = (path.relative_to(MODULES) for path in MODULES.rglob("*.js"))
TEXTS = {name: source(name) for name in (it.with_suffix("").as_posix() for it in PATHS)}
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
        for taker in TEXTS
        for names, module in imports(taker)
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


def test_the_method_knows_no_page():
    method = [name for name in TEXTS if name.startswith("method/")]
    assert method
    for name in method:
        assert {module for _, module in imports(name)} <= {*method}
        assert not re.search(r"\b(document|window)\b", COMMENT.sub("", TEXTS[name]))
