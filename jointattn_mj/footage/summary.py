"""Summary of a viewing: numbers, and notes that explain unusual ones (summary.json)."""

from dataclasses import asdict
from typing import Any

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.faces import KEPT
from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.viewing import Viewing

FEWEST_FPS = 15
"""Images a second below which motion and its end are detected late."""
MISSING_S = 1.0
"""Seconds of its declared length that a file may lack, for headers round."""


def summarise(viewing: Viewing, stopped: bool, wall_seconds: float, som_error: float | None) -> dict[str, Any]:
    """Summary of a viewing, as ``summary.json`` holds it.

    Args:
        viewing: The viewing, after its last frame.
        stopped: Whether it was stopped before the end of the video.
        wall_seconds: Time that it took.
        som_error: Quantisation error of the map of faces; None without a face.

    Raises:
        FootageError: The video has no image.
    """
    footage, mapped, frames = viewing.footage, viewing.mapped, viewing.frames
    if mapped is None:
        raise FootageError(f"{footage.path} has no image")
    watched = frames / RATE
    return {
        "video": {
            "file": str(footage.path),
            "size": [mapped.width, mapped.height],
            "pixel_aspect": footage.aspect,
            "fps": footage.fps or None,
            "declared_seconds": footage.declared_s,
            "images_read": footage.images,
            "went_by_timestamps": footage.timed,
            "timestamp_jumps": footage.jumps,
        },
        "watched_seconds": watched,
        "frames": frames,
        "complete": not stopped and frames < viewing.total,
        "mapping": {
            "rule": "x_px = (u + .5) scale_x - .5 + left, y_px = (v + .5) scale_y - .5 + top; u, v pixels of the video",
            **{name: value for name, value in asdict(mapped).items() if name not in ("width", "height")},
            "cascade_face_side_in_video_px": viewing.face_side,
        },
        "found": dict(zip(viewing.names, (viewing.visible / frames).round(4), strict=True)),
        "moving": dict(zip(viewing.names, (viewing.moves / frames).round(4), strict=True)),
        "fixations": len(viewing.fixations.all),
        "by_candidate": viewing.fixations.shares(viewing.names),
        "face_patterns": min(viewing.album.offered, KEPT),
        "som_quantisation_error": som_error,
        "notes": notes(viewing, stopped),
        "wall_seconds": round(wall_seconds, 2),
    }


def notes(viewing: Viewing, stopped: bool) -> list[str]:
    """Sentences that explain unusual results."""
    footage, frames = viewing.footage, viewing.frames
    said = []
    if stopped:
        said.append(f"stopped after {frames / RATE:.1f} s")
    elif frames < viewing.total and footage.declared_s is not None and frames / RATE < footage.declared_s - MISSING_S:
        said.append(
            f"the file says that it has {footage.declared_s:.1f} s, and {frames / RATE:.1f} s could be read: it is cut "
            "off or damaged, or its header is wrong"
        )
    if not footage.timed and viewing.config.fps is None:
        said.append(
            f"no timestamps in the file: {footage.fps:g} images a second were assumed; the option fps sets them"
        )
    if footage.interlaced:
        said.append("the video is interlaced: every other line was filled in from those around it, in space and time")
    if footage.jumps:
        said.append(f"the timestamps jumped {footage.jumps} times; the time between is left out")
    if frames > RATE and footage.images / (frames / RATE) < FEWEST_FPS:
        said.append(f"fewer than {FEWEST_FPS} images a second: motion is detected late and in leaps")
    if len(viewing.sizes) > 1:
        said.append(f"the image's size changes ({sorted(viewing.sizes)}): the mapping is that of the last")
    if not viewing.coloured:
        said.append("the video is grey: objects are found by their colour, so none can be")
    elif not viewing.visible[:-1].any():
        said.append("no object was found; objects may be colours as picked from the image, such as cup=#c03a2b")
    if not viewing.visible[-1]:
        said.append(
            "no face was found: a face must look at the camera once, and be 24 pixels wide in the robot's image"
        )
    return said
