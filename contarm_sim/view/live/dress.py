"""What viser's page wears: a dark scheme, a layout for phones, words that can be read."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any

_HEAD = b"<title>Viser</title>"


@cache
def _clothes() -> bytes:
    """Return what goes into the head of the page."""
    here = Path(__file__).parent
    style, script = ((here / name).read_text(encoding="utf-8") for name in ("page.css", "page.js"))
    return f"<title>contarm: the live arm</title><style>{style}</style><script>{script}</script>".encode()


def dressed(response: Any) -> Any:
    """Return viser's answer to a request; its page in clothes, everything else as it is."""
    if response.status_code == 200 and _HEAD in response.body[:20_000]:
        response.body = response.body.replace(_HEAD, _clothes(), 1)
        del response.headers["Content-Length"]
        response.headers["Content-Length"] = str(len(response.body))
    return response
