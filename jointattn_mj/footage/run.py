"""Watches a video from beginning to end, and leaves what was perceived and attended to in a folder."""

import json
import math
import time
from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict
from typing import Any

import numpy as np

from jointattn_mj.errors import FootageError
from jointattn_mj.footage.colours import object_colours
from jointattn_mj.footage.config import PerceiveConfig, PerceiveOptions
from jointattn_mj.footage.face_size import face_side, largest_scale
from jointattn_mj.footage.faces import EVERY, FaceAlbum
from jointattn_mj.footage.fixations import Fixations
from jointattn_mj.footage.frame_map import FrameMap
from jointattn_mj.footage.log import PerceptLog
from jointattn_mj.footage.overlay import HEIGHT, WIDTH, FootageOverlay
from jointattn_mj.footage.reader import RATE, Footage, Still
from jointattn_mj.footage.watcher import Watcher
from jointattn_mj.perception.pixels import PixelPerception
from jointattn_mj.recording.files import claim, forget_partial, write_whole
from jointattn_mj.recording.interrupts import deferred
from jointattn_mj.recording.provenance import plain, write_config
from jointattn_mj.recording.reel import Reel, find_ffmpeg

KEPT = 1800
"""Face patterns kept for the map: the three minutes of section 6.4.1 at ten looks a second."""
GREY_SPREAD = 16
"""Grey values between the channels of a pixel, below which it has no colour; compression makes some."""
FEWEST_FPS = 15
"""Pictures a second below which motion and its end are seen late."""
SHORT = 0.9
"""Share of its declared length that a file must hold to count as whole."""


class Viewing:
    """One viewing of a video, frame by frame.

    Attributes:
        footage: The video.
        watcher: Who watches.
        mapped: How its picture comes from the video's; None before the first.
        frames: Frames seen.
        fixations: What it looked at.
        album: Faces that it saw.
        names: Of the candidates.
        rgb: (n, 3) colours of the objects, 0..1.
    """

    def __init__(self, config: PerceiveConfig):
        """Open the video.

        Raises:
            FootageError: There is no such file, or it is no video.
        """
        names, self.rgb = object_colours(config.objects)
        attention, album = (np.random.default_rng(seed) for seed in np.random.SeedSequence(config.seed).spawn(2))
        self.config, self.names = config, (*names, "face")
        self.footage = Footage(config.video, config.fps)
        perceiver = PixelPerception(config.pixels, self.rgb, config.face_follow)
        self.watcher = Watcher(perceiver, config.attention, len(names), config.shift_frames, attention)
        self.mapped: FrameMap | None = None
        self.fixations = Fixations()
        self.album = FaceAlbum(KEPT, perceiver.pattern_size, album)
        self.frames, self.total = 0, math.inf
        if config.max_minutes is not None:
            self.total = max(1, round(config.max_minutes * 60 * RATE))
        self.face_side: float | None = None
        self.seen = np.zeros(len(self.names), int)
        self.moves = np.zeros(len(self.names), int)
        self.coloured = False
        self.sizes: set[tuple[int, int]] = set()
        self.sample = np.zeros((1, 1, 3), np.uint8)
        self._faces = 0

    def measure_face(self) -> None:
        """See how large the face is; only where no scale was given.

        Raises:
            FootageError: The video has no picture.
        """
        if self.config.scale is None:
            self.face_side = face_side(self.footage, self.config.fit, self.config.pixels.faces)

    def see(self, still: Still) -> FrameMap:
        """One frame; how the robot's picture comes from the video's."""
        self.mapped = mapped = self._map(still)
        first_face = self.seen[-1] == 0
        picture = mapped.picture(still.picture) if still.fresh or self.frames == 0 else self.sample
        percept = self.watcher.see(picture, still.fresh, still.cut)
        self.seen += percept.seen
        self.moves += percept.moves
        if still.fresh and percept.seen[-1]:
            if self._faces % EVERY == 0:
                self.album.add(self.watcher.perceiver.face_pattern(), self.frames / RATE)
            self._faces += 1
        if self.frames == 0 or (first_face and percept.seen[-1]):
            self.sample = picture
        if still.fresh and self.frames % RATE == 0 and not self.coloured:
            spread = picture.max(axis=2) - picture.min(axis=2)
            self.coloured = bool(np.percentile(spread, 99) > GREY_SPREAD)
        self.fixations.note(self.watcher, self.frames, mapped)
        self.frames += 1
        return mapped

    def _map(self, still: Still) -> FrameMap:
        height, width = still.picture.shape[:2]
        if self.mapped is not None and (self.mapped.width, self.mapped.height) == (width, height):
            return self.mapped
        self.sizes.add((width, height))
        aspect, fit, scale = self.footage.aspect, self.config.fit, self.config.scale
        if scale is not None:
            return FrameMap.scaled(width, height, aspect, scale)
        fitted = FrameMap.fitted(width, height, aspect, fit)
        most = largest_scale(self.face_side, fitted.scale_y, self.config.pixels.faces)
        return fitted if most == fitted.scale_y else FrameMap.scaled(width, height, aspect, most)


def run_perceive(
    config: PerceiveConfig, options: PerceiveOptions, progress: Callable[[Viewing], object] = lambda viewing: None
) -> dict[str, Any]:
    """Watch a video and leave the results in ``options.out``; returns the summary.

    ``progress`` is called after every second of video. On Ctrl-C or SIGTERM the frame is finished, and what was watched
    so far leaves all its results before KeyboardInterrupt goes on.

    Raises:
        FootageError: The file is no video, or has no picture.
        OutputError: The folder holds another run, or cannot be written.
        VideoError: The overlay cannot be written.
    """
    out, started = options.out, time.perf_counter()
    if options.overlay:
        find_ffmpeg()
    viewing = Viewing(config)
    claim(out, resumable=False)
    forget_partial(out)
    viewing.measure_face()
    write_config(out / "config.yaml", config)
    log = PerceptLog(out / "percepts.parquet", viewing.names)
    stopped = False
    try:
        with deferred() as interrupts, ExitStack() as open_files:
            show = _overlay(viewing, options, log, open_files)
            for still in viewing.footage:
                mapped = viewing.see(still)
                log.add(viewing.watcher, still.number, still.fresh)
                show(still, mapped)
                if viewing.frames % RATE == 0:
                    progress(viewing)
                stopped = interrupts.requested
                if stopped or viewing.frames >= viewing.total:
                    break
    finally:
        log.close()
    summary = _leave_results(viewing, options, stopped, time.perf_counter() - started)
    if stopped:
        raise KeyboardInterrupt
    return summary


def _overlay(
    viewing: Viewing, options: PerceiveOptions, log: PerceptLog, open_files: ExitStack
) -> Callable[[Still, FrameMap], None]:
    """What shows a frame to the overlay video, if there is to be one."""
    if not options.overlay:
        return lambda still, mapped: None
    drawing = FootageOverlay(viewing.names, viewing.rgb, viewing.config.attention)
    reel = open_files.enter_context(Reel(options.out / "overlay.mp4", HEIGHT, WIDTH, RATE / options.overlay_every))

    def show(still: Still, mapped: FrameMap) -> None:
        if (viewing.frames - 1) % options.overlay_every == 0:
            reel.add(drawing.compose(still.picture, mapped, viewing.watcher, log))

    return show


def _leave_results(viewing: Viewing, options: PerceiveOptions, stopped: bool, wall_seconds: float) -> dict[str, Any]:
    from jointattn_mj.footage.figures import draw_fixations
    from jointattn_mj.recording.figures import draw_som
    from jointattn_mj.recording.tables import write_parquet

    out = options.out
    write_parquet(out / "fixations.parquet", viewing.fixations.table(viewing.names))
    draw_fixations(
        out / "fixations.png",
        viewing.sample,
        viewing.fixations.all,
        out / "percepts.parquet",
        viewing.names,
        viewing.rgb,
    )
    error = None
    if viewing.album.seen:
        som = viewing.album.learn(viewing.config.som)
        error = round(som.quantisation_error(viewing.album.patterns), 4)
        draw_som(out / "som.png", som)
        write_parquet(out / "faces.parquet", viewing.album.table(som))
    summary = summarise(viewing, stopped, wall_seconds, error)
    write_whole(out / "summary.json", lambda path: path.write_text(json.dumps(plain(summary), indent=1) + "\n"))
    return summary


def summarise(viewing: Viewing, stopped: bool, wall_seconds: float, som_error: float | None) -> dict[str, Any]:
    """The viewing in numbers: what ``summary.json`` holds."""
    footage, mapped, frames = viewing.footage, viewing.mapped, viewing.frames
    if mapped is None:
        raise FootageError(f"{footage.path} has no picture")
    watched = frames / RATE
    return {
        "video": {
            "file": str(footage.path),
            "size": [mapped.width, mapped.height],
            "pixel_aspect": footage.aspect,
            "fps": footage.fps or None,
            "declared_seconds": footage.declared_s,
            "pictures_read": footage.pictures,
            "went_by_timestamps": footage.timed,
            "timestamp_jumps": footage.jumps,
        },
        "watched_seconds": watched,
        "frames": frames,
        "complete": not stopped and not math.isfinite(viewing.total),
        "mapping": {
            "rule": "x_px = (u + .5) scale_x - .5 + left, y_px = (v + .5) scale_y - .5 + top; u, v pixels of the video",
            **{name: value for name, value in asdict(mapped).items() if name not in ("width", "height")},
            "cascade_face_side_in_video_px": viewing.face_side,
        },
        "found": dict(zip(viewing.names, (viewing.seen / frames).round(4), strict=True)),
        "moving": dict(zip(viewing.names, (viewing.moves / frames).round(4), strict=True)),
        "fixations": len(viewing.fixations.all),
        "by_candidate": viewing.fixations.shares(viewing.names),
        "face_patterns": min(viewing.album.seen, KEPT),
        "som_quantisation_error": som_error,
        "notes": notes(viewing, stopped),
        "wall_seconds": round(wall_seconds, 2),
    }


def notes(viewing: Viewing, stopped: bool) -> list[str]:
    """What somebody should know who wonders about the results."""
    footage, frames = viewing.footage, viewing.frames
    said = []
    if stopped:
        said.append(f"stopped after {frames / RATE:.1f} s")
    elif frames < viewing.total and footage.declared_s is not None and frames / RATE < SHORT * footage.declared_s:
        said.append(
            f"the file says that it has {footage.declared_s:.1f} s, and {frames / RATE:.1f} s could be read: cut off, "
            "or damaged"
        )
    if not footage.timed and viewing.config.fps is None:
        said.append(f"no timestamps in the file: {footage.fps:g} pictures a second were assumed; --fps says otherwise")
    if footage.jumps:
        said.append(f"the timestamps jumped {footage.jumps} times; the time between is left out")
    if frames > RATE and footage.pictures / (frames / RATE) < FEWEST_FPS:
        said.append(f"fewer than {FEWEST_FPS} pictures a second: motion is seen late and in leaps")
    if len(viewing.sizes) > 1:
        said.append(f"the picture's size changes ({sorted(viewing.sizes)}): the mapping is that of the last")
    if not viewing.coloured:
        said.append("the video is grey: objects are found by their colour, so none can be")
    elif not viewing.seen[:-1].any():
        said.append("no object was found; --objects cup=#c03a2b takes a colour as picked from the picture")
    if not viewing.seen[-1]:
        said.append("no face was found: it must look at the camera once, and be 24 pixels wide in the robot's picture")
    return said
