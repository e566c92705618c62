"""A box on a picture, drawn with the mouse.

`BoxPicker` is a widget whose browser half is box_picker.js beside this file.  Used in
notebook 03.
"""

from collections.abc import Sequence
from pathlib import Path

import anywidget
import traitlets

from mkt.figures.pictures import image_file
from mkt.types import Frame

BESIDE = Path(__file__)


class BoxPicker(anywidget.AnyWidget):
    """A picture and a box on it: for mouse, arrow keys and five number fields.

    Attributes
    ----------
    frame : bytes
        Of an image file, see `show`.
    box : list of five float
        x, y, w, h, angle: upper left corner and size [px] before the clockwise rotation
        about its centre [deg], the picture's corner being 0,0.
    enabled : bool
        Whether the box can be changed.
    """

    _esm = BESIDE.with_suffix(".js")
    _css = BESIDE.with_suffix(".css")
    frame = traitlets.Bytes(b"").tag(sync=True)
    box = traitlets.List(
        traitlets.Float(), [0.0, 0.0, 1.0, 1.0, 0.0], minlen=5, maxlen=5
    ).tag(sync=True)
    enabled = traitlets.Bool(True).tag(sync=True)

    def show(self, frame: Frame, box: Sequence[float]) -> None:
        """Put another picture (H, W, 3) uint8 RGB under another box."""
        png = image_file(frame, ".png")
        with self.hold_sync():
            self.frame = png
            self.box = [float(number) for number in box]
