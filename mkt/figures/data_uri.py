"""Bytes of a file as an address that a page can hold."""

import base64


def data_uri(kind: str, data: bytes) -> str:
    """The address of a file of a kind, such as image/webp."""
    return f"data:{kind};base64,{base64.b64encode(data).decode()}"
