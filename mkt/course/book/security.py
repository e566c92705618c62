"""What the pages may do: run their own scripts, and ask nothing of any other place.

A Content-Security-Policy in the head of each page holds the browser to that.  It allows
no script inside a page, so what the theme has there is moved into files.
"""

import hashlib
import os
import re
from pathlib import Path

# Where the worker of the live figures comes from, and the films inside pages: `blob:`
# and `data:` are texts and pictures that a page made or holds itself.
POLICY = "; ".join(
    [
        "default-src 'none'",
        "script-src 'self'",
        "worker-src blob:",
        "style-src 'self' 'unsafe-inline'",
        "img-src 'self' data: blob:",
        "media-src 'self' data: blob:",
        "font-src 'self'",
        "form-action 'self'",
        "base-uri 'none'",
    ]
)
META = f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
HEAD = re.compile(r"<head>|(?=<meta charset)", re.IGNORECASE)
INSIDE = re.compile(r"<script>(.*?)</script>", re.DOTALL)


def seal(folder: Path) -> None:
    """Give every page of a site the policy, and move its inner scripts into files."""
    for page in folder.rglob("*.html"):
        static = os.path.relpath(folder / "_static", page.parent)
        text = HEAD.sub(_with_policy, page.read_text(encoding="utf-8"), count=1)
        for script in set(INSIDE.findall(text)):
            name = f"{hashlib.sha256(script.encode()).hexdigest()[:16]}.js"
            (folder / "_static" / name).write_text(script, encoding="utf-8")
            address = Path(static, name).as_posix()
            text = text.replace(
                f"<script>{script}</script>", f'<script src="{address}"></script>'
            )
        page.write_text(text, encoding="utf-8")


def _with_policy(found: re.Match) -> str:
    return found[0] + META
