"""Summary of a viewing: numbers, and notes that explain unusual ones (summary.json)."""

from dataclasses import asdict
from typing import Any

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.colours import sought_objects
from jointattn_mj.footage.faces import KEPT
from jointattn_mj.footage.followed import PATTERN_HEIGHTS
from jointattn_mj.footage.reader import MISSING_S, RATE
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.io.progress import count
from jointattn_mj.perception.flow import BLOCK

OLD_KEYS = {"found": "detected"}
"""Keys of ``summary.json`` by their names in the last version."""
FEWEST_FPS = 15
"""Images a second below which motion and its end are detected late."""
MOST_CHECKS = 100
"""Most entries of the list of what to check; checks.csv has all."""
CAMERA_SHARE = 0.05
"""Share of the frames in which the camera must move to be told of."""
SEVERAL_SHARE = 0.3
"""Share of the images in which an object must have several areas to be told of."""


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
            "start_seconds": round(footage.start_s, 6),
            "cuts": viewing.shots.cuts,
            "camera_moves": round(viewing.camera_moves / frames, 4),
        },
        "watched_seconds": watched,
        "frames": frames,
        "complete": not stopped and frames < viewing.total,
        "mapping": {
            "rule": "x_px = (u + .5) scale_x - .5 + left, y_px = (v + .5) scale_y - .5 + top; u, v pixels of the video",
            **{name: value for name, value in asdict(mapped).items() if name not in ("width", "height")},
            "cascade_face_side_in_video_px": viewing.face_side,
        },
        "detected": dict(zip(viewing.names, (viewing.visible / frames).round(4), strict=True)),
        "moving": dict(zip(viewing.names, (viewing.moves / frames).round(4), strict=True)),
        "people": _people(viewing),
        "check": [
            {
                "from_s": round(footage.time_of(check.start), 3),
                "to_s": round(footage.time_of(check.end), 3),
                "what": check.code,
            }
            for check in viewing.checks()[:MOST_CHECKS]
        ],
        "checks": len(viewing.checks()),
        "fixations": len(viewing.fixations.all),
        "by_candidate": viewing.fixations.shares(viewing.names),
        "face_patterns": min(viewing.album.offered, KEPT),
        "som_quantisation_error": som_error,
        "notes": notes(viewing, stopped),
        "wall_seconds": round(wall_seconds, 2),
    }


def _time(viewing: Viewing, frame: int) -> float:
    return round(viewing.footage.time_of(frame), 3)


def _people(viewing: Viewing) -> list[dict[str, Any]]:
    """Who was in the video, how long, and how sure that is."""
    people = viewing.people
    if people is None:
        return []
    said = []
    for number, person in people.people.items():
        tracks = [(*people.images[track], sure) for track, (owner, sure) in people.owner.items() if owner == number]
        said.append(
            {
                "person": number,
                "images": sum(count for count, *_ in tracks),
                "images_unsure": sum(count for count, _, _, sure in tracks if not sure),
                "from_s": _time(viewing, min((first for _, first, _, _ in tracks), default=0)),
                "to_s": _time(viewing, max((last for _, _, last, _ in tracks), default=0)),
                "perhaps_the_same_as": person.perhaps or None,
            }
        )
    return said


def notes(viewing: Viewing, stopped: bool) -> list[str]:
    """Sentences that explain unusual results."""
    footage, frames = viewing.footage, viewing.frames
    said = []
    if stopped:
        said.append(f"stopped after {frames / RATE:.1f} s")
    elif (
        frames < viewing.total
        and footage.declared_s is not None
        and not footage.jumps
        and footage.time_of(frames) < footage.declared_s - MISSING_S
    ):
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
        said.append(
            f"the timestamps jumped {footage.jumps} times; the time between is left out, and later times are not those "
            "of the file"
        )
    if frames > RATE and footage.images * RATE < FEWEST_FPS * frames:
        said.append(f"fewer than {FEWEST_FPS} images a second: motion is detected late and in leaps")
    if len(viewing.sizes) > 1:
        said.append(f"the image's size changes ({sorted(viewing.sizes)}): the mapping is that of the last")
    said += _of_camera(viewing) + _of_people(viewing)
    if not viewing.coloured and all(item.picked is None for item in sought_objects(viewing.config.objects)):
        said.append("the video is grey: objects are found by their colour, so none can be")
    elif not viewing.visible[:-1].any():
        said.append("no object was found; objects may be picked in the video by time and pixel: cup@12.5s:420,310")
    if not viewing.visible[-1] and viewing.people is not None and viewing.people.people:
        numbers = ", ".join(str(number) for number in viewing.people.people)
        said.append(f"no face was the face of interest, {viewing.config.face}; the people in the video are {numbers}")
    elif not viewing.visible[-1]:
        templates = "a face must look at the camera once, and be 24 pixels wide in the robot's image"
        small = "a face must be 10 pixels high at least, and be shown from the front or from the side"
        said.append(f"no face was found: {templates if viewing.people is None else small}")
    return said


def _of_camera(viewing: Viewing) -> list[str]:
    """Sentences on cuts, and on a camera that moves."""
    said, moved, cuts = [], viewing.camera_moves / viewing.frames, viewing.shots.cuts
    if cuts:
        said.append(f"the video has {count(cuts, 'cut')}; faces and objects were searched for anew after each")
    if moved > CAMERA_SHARE:
        said.append(
            f"the camera moves in {moved:.0%} of the frames: nothing is said to move meanwhile, and locations are "
            "those in the image"
        )
    return said


def _of_people(viewing: Viewing) -> list[str]:
    """Sentences on who was there, and on objects that are several."""
    said = []
    people = [] if viewing.people is None else list(viewing.people.people.values())
    if len(people) > 1:
        said.append(
            f"{len(people)} people were told apart; the option face, such as 2, makes another the face of interest"
        )
    least = (2 * viewing.config.pixels.motion.face_inset_px + BLOCK) / PATTERN_HEIGHTS
    if 0 < viewing.face_px < least:
        said.append(
            f"the face is {viewing.face_px:.0f} pixels high in the robot's image, and below {least:.0f} it is not seen "
            "whether it moves; the option fit fill, or scale, makes it larger"
        )
    said += [f"person {person.number} is perhaps person {person.perhaps}" for person in people if person.perhaps]
    areas = viewing.watcher.perceiver.areas.counts
    for sought, counts in zip(sought_objects(viewing.config.objects), areas, strict=True):
        if counts[viewing.config.areas_each + 1 :].sum() > SEVERAL_SHARE * counts.sum():
            said.append(f"{sought.name} has more areas than are followed; the option areas_each follows several")
    return said
