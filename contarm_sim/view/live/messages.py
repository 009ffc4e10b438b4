"""What a page may say: its camera, a drag, a control's new value. All else is not understood."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import msgspec

Number = Annotated[float, msgspec.Meta(ge=-1e15, le=1e15)]
"""A finite number, whole or not."""

Triple = tuple[Number, Number, Number]
Pair = tuple[float, float]
Text = Annotated[str, msgspec.Meta(max_length=200)]


class Camera(msgspec.Struct, tag="ViewerCameraMessage", tag_field="type", forbid_unknown_fields=True):
    """Where somebody looks from [m, rad, pixels]."""

    wxyz: tuple[Number, Number, Number, Number]
    position: Triple
    fov: Number
    near: Number
    far: Number
    image_height: Number
    image_width: Number
    look_at: Triple
    up_direction: Triple

    @property
    def about(self) -> str:
        """What this is the latest word on."""
        return "camera"


class Drag(msgspec.Struct, tag="SceneNodeDragMessage", tag_field="type", forbid_unknown_fields=True):
    """Something in the scene pulled with the mouse [m]."""

    phase: Literal["start", "update", "end"]
    name: Text
    instance_index: int | None
    start_position: Triple
    start_screen_pos: Pair
    end_position: Triple
    end_screen_pos: Pair
    button: Literal["left", "middle", "right"]
    modifier: Text | None
    owner: Text

    @property
    def about(self) -> str:
        """What this is the latest word on."""
        return f"drag {self.phase}"


class NewValue(msgspec.Struct, forbid_unknown_fields=True):
    """The value of a control, and no other attribute of it."""

    value: Number | bool | Text


class Update(msgspec.Struct, tag="GuiUpdateMessage", tag_field="type", forbid_unknown_fields=True):
    """A control set."""

    uuid: Text
    updates: NewValue

    @property
    def about(self) -> str:
        """What this is the latest word on."""
        return self.uuid


Said = Camera | Drag | Update
SAID: tuple[Any, ...] = (Camera, Drag, Update)

_DECODER = msgspec.msgpack.Decoder(Said)


def understood(raw: bytes) -> Said | None:
    """Return what a message says, or None if it is none that a page sends."""
    try:
        return _DECODER.decode(raw)
    except (ValueError, RecursionError):  # all of msgspec's errors are ValueErrors
        return None


def worded(said: Said) -> bytes:
    """Return what was said as a message, without anything that was not understood."""
    return msgspec.msgpack.encode(said)
