"""What Windows cannot do is not in the code, or is asked for with an answer for it.

Nobody has run the project there; this is found by reading, and kept by these tests.
"""

import ast
import re

import pytest

from mkt.files import PACKAGE, ROOT

MODULES = sorted(PACKAGE.rglob("*.py"))
# Not on Windows; each file here imports them inside a function or under a test.
UNIX = {"fcntl", "resource", "pwd", "grp", "termios", "pty"}
TEXT = {"read_text", "write_text"}
# Names that Windows keeps for devices, and signs that it does not take in a name.
RESERVED = re.compile(r"(?i)^(con|prn|aux|nul|com\d|lpt\d)(\.|$)")
FORBIDDEN = set('<>:"\\|?*')


def calls(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Call):
            name = node.func.attr if isinstance(node.func, ast.Attribute) else ""
            name = node.func.id if isinstance(node.func, ast.Name) else name
            yield name, node


def binary(node):
    """Whether a call of open asks for bytes."""
    modes = [*node.args[:2], *(k.value for k in node.keywords if k.arg == "mode")]
    texts = [m.value for m in modes if isinstance(m, ast.Constant)]
    return any(isinstance(text, str) and "b" in text for text in texts)


def says_encoding(name, node):
    if any(keyword.arg == "encoding" for keyword in node.keywords):
        return True
    positions = {"read_text": 0, "write_text": 1}
    return name in positions and len(node.args) > positions[name]


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_text_is_read_and_written_in_an_encoding_that_is_said(path):
    unsaid = [
        node.lineno
        for name, node in calls(path)
        if (name in TEXT or (name == "open" and not binary(node)))
        and not says_encoding(name, node)
        and not _of_another_thing(node)
    ]
    assert not unsaid, f"{path.name}, lines {unsaid}: give the encoding"


def _of_another_thing(node):
    """Opening that is no file's: of a tab of the browser, an image, a descriptor."""
    owner = node.func.value if isinstance(node.func, ast.Attribute) else None
    return isinstance(owner, ast.Name) and owner.id in {"webbrowser", "Image", "os"}


@pytest.mark.parametrize("path", MODULES, ids=lambda path: path.stem)
def test_modules_that_windows_lacks_are_not_imported_with_a_module(path):
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Import):
            assert not UNIX & {alias.name for alias in node.names}
        if isinstance(node, ast.ImportFrom):
            assert node.module not in UNIX


def test_every_file_can_have_its_name_on_every_system():
    files = [
        path.relative_to(ROOT)
        for folder in ("mkt", "tests", "notebooks", "data")
        for path in (ROOT / folder).rglob("*")
        if "__pycache__" not in path.parts
    ]
    for path in files:
        for part in path.parts:
            assert not RESERVED.match(part) and not FORBIDDEN & set(part), path
    folded = [str(path).lower() for path in files]
    assert len(set(folded)) == len(folded)


def test_calls_that_only_unix_knows_are_not_made():
    only = {"fork", "killpg", "setsid", "mkfifo", "chown", "getuid"}
    found = {
        (path.stem, name) for path in MODULES for name, _ in calls(path) if name in only
    }
    assert not found
