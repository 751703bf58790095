"""A video from Python: the same options and results as ``jointattn perceive``, or frame after frame."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields
from os import PathLike
from typing import Any, Literal, TypedDict, Unpack, overload

from jointattn_mj.errors import ConfigError
from jointattn_mj.footage.areas import AreaConfig
from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.frame_map import Fit
from jointattn_mj.footage.frames import PerceivedFrame
from jointattn_mj.footage.looks.config import LooksConfig
from jointattn_mj.footage.people import PeopleConfig
from jointattn_mj.footage.rest import RestConfig
from jointattn_mj.footage.result import PerceptionResult
from jointattn_mj.footage.run import percepts, run_perceive
from jointattn_mj.footage.shots import ShotConfig
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.gaze_following.attention import AttentionConfig
from jointattn_mj.options import as_arguments, changed, check_called, check_names, options_of_parts, path_of
from jointattn_mj.perception.pixels import PixelConfig
from jointattn_mj.perception.som import SOMConfig


class PerceiveFields(TypedDict, total=False):
    """Options of ``perceive`` that decide what is perceived; :class:`PerceiveConfig` has their defaults."""

    objects: tuple[str, ...]
    areas_each: int
    detector: Literal["yunet", "templates"]
    face: str
    looks: bool
    labels: str | PathLike[str] | None
    max_minutes: float | None
    fps: float | None
    fit: Fit
    scale: float | None
    face_follow: float
    shift_frames: int
    seed: int
    attention: AttentionConfig | Mapping[str, Any]
    pixels: PixelConfig | Mapping[str, Any]
    som: SOMConfig | Mapping[str, Any]
    people: PeopleConfig | Mapping[str, Any]
    shots: ShotConfig | Mapping[str, Any]
    areas: AreaConfig | Mapping[str, Any]
    rest: RestConfig | Mapping[str, Any]
    coding: LooksConfig | Mapping[str, Any]
    motion_cues: bool


@overload
def perceive(
    video: str | PathLike[str], out: None = None, **options: Unpack[PerceiveFields]
) -> Iterator[PerceivedFrame]: ...
@overload
def perceive(
    video: str | PathLike[str],
    out: str | PathLike[str],
    *,
    resume: bool = False,
    overlay: bool = True,
    blur_faces: bool = False,
    overlay_every: int = 1,
    checkpoint_minutes: float = 2.0,
    check: str | PathLike[str] | None = None,
    page: bool = True,
    progress: Callable[[Viewing], object] = lambda viewing: None,
    **options: Unpack[PerceiveFields],
) -> PerceptionResult: ...
def perceive(
    video: str | PathLike[str],
    out: str | PathLike[str] | None = None,
    *,
    resume: bool = False,
    overlay: bool = True,
    blur_faces: bool = False,
    overlay_every: int = 1,
    checkpoint_minutes: float = 2.0,
    check: str | PathLike[str] | None = None,
    page: bool = True,
    progress: Callable[[Viewing], object] = lambda viewing: None,
    **options: Unpack[PerceiveFields],
) -> Iterator[PerceivedFrame] | PerceptionResult:
    """Watch a video of a person at a table: what the robot would perceive, and where it would look (6.3.2).

    Without ``out`` the video is watched as far as you iterate, and nothing is written. With ``out`` it is watched to
    its end at once, and the results go to that folder.

    Args:
        video: Video file.
        out: Folder for the results: percepts, people, fixations, events, figures, and a video with all of it drawn on.
        resume: Continue from the checkpoint in ``out``.
        overlay: Write that video (slow).
        blur_faces: Make faces unrecognisable in that video and in figures.
        overlay_every: Write one image of it for so many frames.
        checkpoint_minutes: Minutes of the video between checkpoints in ``out``.
        check: A person's codings of where the person of interest looks; kappa goes to the summary (with ``looks``).
        page: With ``looks``, make the page of ``jointattn recordings`` from the looks.
        progress: Is called after every second of video, with ``out``.
        **options: Fields of ``PerceiveConfig``: ``objects`` (what to look for, such as
            ``("blue", "cup=#2b3ac0", "ball@12.5s:420,310")``), ``areas_each``, ``detector``, ``face``, ``looks``,
            ``labels``, ``max_minutes``, ``fps``, ``fit``, ``scale``, ``face_follow``, ``shift_frames``, ``seed``,
            ``attention``, ``pixels``, ``som``, ``people``, ``shots``, ``areas``, ``rest``, ``coding``; these
            groups as a config, or a mapping of what differs; and ``motion_cues``.

    Returns:
        Without ``out`` an iterator over :class:`PerceivedFrame`, a thirtieth of a second each: face, objects, optical
        flow, fixation, time. With ``out`` a :class:`PerceptionResult`, which iterates over the same frames.

    Raises:
        FootageError: The file is no video, or has no image.
        ExtraError: The extra ``footage``, which has the network that finds faces, is not installed.
        ConfigError: Options that are not allowed.
        OutputError: The folder holds another run, or cannot be written.
        CheckpointError: ``resume`` without a fitting checkpoint.
        VideoError: The overlay cannot be written.

    Examples:
        >>> from jointattn_mj import perceive
        >>> frames = perceive("out/clip.mp4")
        >>> next(frames).time_s
        0.0
        >>> {frame.fixation for frame in frames} <= {None, "face", "yellow", "blue", "green"}
        True
    """
    check_called("progress", progress)
    known = [field.name for kind in (PerceiveConfig, PerceiveOptions) for field in fields(kind)]
    check_names("perceive", options, [*known, *options_of_parts(PerceiveConfig)])
    config = changed(PerceiveConfig(path_of(video, "video")), options)
    if out is not None:
        codings = None if check is None else path_of(check, "check")
        with as_arguments():
            where = PerceiveOptions(
                path_of(out, "out"), resume, overlay, blur_faces, overlay_every, checkpoint_minutes, codings, page
            )
        run_perceive(config, where, progress)
        return PerceptionResult.open(where.out)
    if resume:
        raise ConfigError("resume needs the folder out; got out=None")
    return percepts(config)
