"""Pixels as the bytes of an image file, and bytes as an address in a page."""

import base64

import cv2

from mkt.types import NDArray


def image_file(pixels: NDArray, ending: str, *options: int) -> bytes:
    """Pixels (h, w, 3) RGB, or with their opacity (h, w, 4), as an image file.

    Parameters
    ----------
    pixels : uint8 array
    ending : str
        Of a file of that kind, ".png".
    options : int
        Of `cv2.imencode`, names and values in turn.
    """
    opaque = pixels.shape[2] == 3
    code = cv2.COLOR_RGB2BGR if opaque else cv2.COLOR_RGBA2BGRA
    return cv2.imencode(ending, cv2.cvtColor(pixels, code), options)[1].tobytes()


def data_uri(kind: str, data: bytes) -> str:
    """The address of a file of a kind, such as image/webp."""
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"
