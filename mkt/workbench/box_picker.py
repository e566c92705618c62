"""A box on a picture, drawn with the mouse: `BoxPicker`, a widget whose browser half is box_picker.js beside this file.

Used in notebook 03.
"""

from pathlib import Path

import anywidget
import cv2
import traitlets

_CSS = """
.mkt-box-canvas { display: block; max-width: 100%; cursor: crosshair; touch-action: none; border-radius: 4px; }
.mkt-box-canvas:focus-visible { outline: 2px solid #1a6fb0; outline-offset: 2px; }
.mkt-busy .mkt-box-canvas { cursor: not-allowed; opacity: 0.6; }
.mkt-box-fields { display: flex; flex-wrap: wrap; gap: 0.3em 0.9em; margin-top: 0.4em; }
.mkt-box-field { width: 4.6em; font: inherit; color: inherit; background: transparent; border: 1px solid #808080; border-radius: 3px; }
"""


class BoxPicker(anywidget.AnyWidget):
    """A picture and a box on it, which the mouse, the arrow keys and five number fields change.

    frame: bytes of an image file, see `show`; enabled: whether the box can be changed.
    box: x, y, w, h, angle: upper left corner and size [px] before the clockwise rotation about its centre [degrees], the picture's corner being 0,0.
    """

    _esm = Path(__file__).with_suffix(".js")
    _css = _CSS
    frame = traitlets.Bytes(b"").tag(sync=True)
    box = traitlets.List(traitlets.Float(), [0.0, 0.0, 1.0, 1.0, 0.0], minlen=5, maxlen=5).tag(sync=True)
    enabled = traitlets.Bool(True).tag(sync=True)

    def show(self, frame, box):
        """Put another picture (H, W, 3) uint8 RGB under another box."""
        with self.hold_sync():
            self.frame = cv2.imencode(".png", cv2.cvtColor(frame, cv2.COLOR_RGB2BGR))[1].tobytes()
            self.box = [float(number) for number in box]
