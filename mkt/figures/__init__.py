"""One door to every figure: `show` draws one in a notebook, `explore` adds its sliders.

In JupyterLab `explore` is a panel whose every slider position the running kernel draws
(`mkt.figures.panel`), or a live one that computes in the browser
(`mkt.figures.live_panel`).  In the book there is no kernel, so with ``MKT_STATIC=1`` in
the environment it is a `mkt.figures.static_panel.StaticPanel`: the live one again, or a
few positions of each slider, drawn beforehand.  All have ``values``, the parameters as
they stand, so that a later cell reads the same in any.

Explained in notebook 01.
"""

import os
from typing import Any


def is_static() -> bool:
    """Whether what is shown will stand on a page without a kernel: MKT_STATIC=1."""
    return os.environ.get("MKT_STATIC") == "1"


def show(name: str, **parameters: Any) -> Any:
    """Draw a registered figure with its defaults, except for some parameters.

    Returns
    -------
    IPython.display.HTML or StaticPanel
        With the caption below; the latter in the book.

    Raises
    ------
    ValueError
        For an unknown figure or parameter, with the known ones.
    """
    from mkt.figures import panel, registry, static_panel  # they need the notebook's

    entry = registry.FIGURES[name]
    if is_static():
        return static_panel.StaticPanel(entry, entry.defaults | parameters)
    return panel.picture(entry, parameters)


def explore(name: str, **fixed: Any) -> Any:
    """A registered figure with its sliders.

    Parameters
    ----------
    name : str
    **fixed
        Parameters that keep their value and lose their slider.

    Returns
    -------
    Panel, LivePanel or StaticPanel
        The last in the book; a live one where the figure is live and nothing is fixed.

    Raises
    ------
    ValueError
        For an unknown figure or parameter, with the known ones.
    """
    from mkt.figures import live_panel, panel, registry, static_panel

    entry = registry.FIGURES[name]
    if is_static():
        return static_panel.StaticPanel(entry, fixed)
    if entry.live and not fixed:
        return live_panel.LivePanel(entry)
    return panel.Panel(entry, fixed)
