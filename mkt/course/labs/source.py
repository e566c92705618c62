"""What students wrote as Python reads it, whatever it is."""

import ast
import re

LENDERS = "mkt", "scipy"  # packages in which the pieces of a lab are ready-made
LONGEST = 10_000  # [letters] that are read, each for half a kilobyte of memory


def parsed(source: str) -> ast.Module:
    """A cell as Python reads it; empty where it cannot, which others say."""
    try:
        return ast.parse(source)
    # The last two are what Python says of what is nested too deep.
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        return ast.Module([], [])


def functions(source: str) -> list[str]:
    """The functions that a cell defines."""
    body = parsed(source).body
    return [node.name for node in body if isinstance(node, ast.FunctionDef)]


def imported(source: str) -> list[tuple[str, str]]:
    """What a cell imports from `LENDERS`: its name here, and the whole one there."""
    found = []
    for node in ast.walk(parsed(source[:LONGEST])):
        if isinstance(node, ast.Import):
            found += [(one.asname or first(one.name), one.name) for one in node.names]
        elif isinstance(node, ast.ImportFrom) and not node.level:
            found += [
                (one.asname or one.name, f"{node.module}.{one.name}")
                for one in node.names
            ]
    return [(here, there) for here, there in found if first(there) in LENDERS]


def used(source: str) -> set[str]:
    """What a cell uses and does not make itself, with its dots: `mkt.errors`."""
    nodes = list(ast.walk(parsed(source[:LONGEST])))
    names = [node for node in nodes if isinstance(node, ast.Name)]
    made = {node.id for node in names if not isinstance(node.ctx, ast.Load)}
    made |= {node.arg for node in nodes if isinstance(node, ast.arg)}
    within = {node.value for node in nodes if isinstance(node, ast.Attribute)}
    asked = [node for node in nodes if isinstance(node, ast.Name | ast.Attribute)]
    whole = [ast.unparse(node) for node in asked if node not in within]
    # Without what is asked of something that has no name, such as `f(x).y`.
    dotted = [one for one in whole if re.fullmatch(r"[\w.]+", one)]
    return {one for one in dotted if first(one) not in made}


def first(dotted: str) -> str:
    """The name that a dotted name begins with."""
    return dotted.partition(".")[0]
