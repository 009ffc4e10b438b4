"""Hatchling's hook: on a package index, README's pictures and links need the repository's address in front.

The address is Repository under [project.urls] in pyproject.toml, and is set there alone. As long as it is not set,
README stays as it is.
"""

from __future__ import annotations

import re
from pathlib import Path

from hatchling.metadata.plugin.interface import MetadataHookInterface

PICTURE = re.compile(r'((?:!\[[^\]]*\]\(|src="))(?!https?://)([^)"\s]+)')
LINK = re.compile(r"((?<!!)\[[^\]]*\]\()(?!https?://|#)([^)\s]+)")


def absolute(text: str, repository: str | None) -> str:
    """Return Markdown whose relative pictures and links have a repository's address in front, as GitHub has them."""
    if not repository:
        return text
    address = repository.rstrip("/")
    text = PICTURE.sub(rf"\g<1>{address}/raw/HEAD/\g<2>", text)
    return LINK.sub(rf"\g<1>{address}/blob/HEAD/\g<2>", text)


class Readme(MetadataHookInterface):
    """Sets the field `readme`."""

    def update(self, metadata: dict) -> None:
        """Put README with absolute addresses into the package's metadata."""
        text = (Path(self.root) / "README.md").read_text(encoding="utf-8")
        repository = metadata.get("urls", {}).get("Repository")
        metadata["readme"] = {"content-type": "text/markdown", "text": absolute(text, repository)}
