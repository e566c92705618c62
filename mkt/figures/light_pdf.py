"""A PDF of matplotlib with its photographs as JPEG, which matplotlib does not write.

Letters and lines stay what they are.  A film strip becomes a quarter of its size.
"""

import re
import struct
import zlib

import cv2
import numpy as np

QUALITY = 75
# A photograph of matplotlib: the bytes of a PNG without what stands round them there.
PHOTOGRAPH = re.compile(
    rb"(?P<head>[^\[]*/Width (?P<width>\d+) /Height (?P<height>\d+)\s"
    rb"/ColorSpace /DeviceRGB\s[^\[]*?)/Filter /FlateDecode\s/DecodeParms <<[^>]*>>\s"
    rb"/Length \d+ 0 R\s>>\sstream\n(?P<body>.*)\nendstream\nendobj\n",
    re.DOTALL,
)
TABLE = re.compile(rb"xref\n0 \d+\n(.*?)(trailer\n.*?startxref\n)\d+", re.DOTALL)


def lighter(pdf: bytes) -> bytes:
    """The same PDF with each photograph as JPEG where that is smaller.

    Parameters
    ----------
    pdf : bytes
        As matplotlib writes it.
    """
    start = int(pdf[pdf.rindex(b"startxref") :].split()[1])
    found = TABLE.match(pdf, start)
    assert found, "matplotlib's PDF ends in a table"
    lines = found[1].splitlines()
    places = {k: int(line[:10]) for k, line in enumerate(lines) if line[17:18] == b"n"}
    order = sorted(places, key=places.__getitem__)
    ends = [*(places[k] for k in order[1:]), start]
    written = bytearray(pdf[: places[order[0]]])
    for k, end in zip(order, ends, strict=True):
        thing = pdf[places[k] : end]
        lines[k] = b"%010d 00000 n " % len(written)
        written += PHOTOGRAPH.sub(_smaller, thing)
    table = b"xref\n0 %d\n" % len(lines) + b"".join(line + b"\n" for line in lines)
    place = len(written)
    return bytes(written) + table + found[2] + b"%d\n%%%%EOF\n" % place


def _smaller(found: re.Match) -> bytes:
    """The object of a photograph with its JPEG, or itself."""
    png = _png(int(found["width"]), int(found["height"]), found["body"])
    pixels = cv2.imdecode(np.frombuffer(png, np.uint8), cv2.IMREAD_COLOR)
    jpeg = cv2.imencode(".jpg", pixels, (cv2.IMWRITE_JPEG_QUALITY, QUALITY))[1]
    if jpeg.size >= len(found["body"]):
        return found[0]
    filtered = b"/Filter /DCTDecode /Length %d >>\nstream\n" % jpeg.size
    return found["head"] + filtered + jpeg.tobytes() + b"\nendstream\nendobj\n"


def _png(width: int, height: int, body: bytes) -> bytes:
    """A PNG of 8 bit RGB."""
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = (b"IHDR", head), (b"IDAT", body), (b"IEND", b"")
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data))
        + kind
        + data
        + struct.pack(">I", zlib.crc32(kind + data))
        for kind, data in chunks
    )
