"""Synthetic sequences with exact truth, rendered from named specifications.

`SCENES` has those of commands and tables by name: functions ``seed, item, ground ->
Scene`` that register themselves where they are written.
"""

from mkt.registry import Registry

#: The drawn scenes by name, functions ``seed, item, ground -> Scene``.
#:
#: :meta hide-value:
SCENES = Registry("scene", "mkt.scenes", order=str)
