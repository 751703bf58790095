"""One viewing of a video, frame by frame, without files."""

import math
from collections import deque
from dataclasses import replace
from itertools import islice
from typing import Any

import numpy as np

from jointattn_mj.errors import CheckpointError
from jointattn_mj.footage.areas import FootageAreas
from jointattn_mj.footage.checks import CHECK, LOST, LOST_FRAMES, note_checks
from jointattn_mj.footage.colours import candidate_names, sought_objects
from jointattn_mj.footage.config import PerceiveConfig
from jointattn_mj.footage.face_size import face_side, largest_scale
from jointattn_mj.footage.faces import EVERY, KEPT, FaceAlbum
from jointattn_mj.footage.fixations import Fixations
from jointattn_mj.footage.followed import FollowedFace
from jointattn_mj.footage.frame_map import IMAGE_HEIGHT, IMAGE_WIDTH, FrameMap
from jointattn_mj.footage.interest import FaceOfInterest, FaceRule
from jointattn_mj.footage.labels import label_table
from jointattn_mj.footage.people import People, Sighting
from jointattn_mj.footage.perceiving import FootagePerception
from jointattn_mj.footage.picked import picked_tables
from jointattn_mj.footage.reader import RATE, Footage, Still
from jointattn_mj.footage.rest import Rest
from jointattn_mj.footage.shots import Shots
from jointattn_mj.footage.spans import Span, Spans
from jointattn_mj.footage.watcher import Watcher
from jointattn_mj.footage.yunet import model_file

STATE = (
    "watcher", "mapped", "fixations", "album", "frames", "face_side", "visible", "moves", "sample", "coloured", "sizes",
    "_faces", "rgb", "people", "shots", "interest", "spans", "camera_moves", "_chosen_last", "sample_faces", "face_px",
)  # fmt: skip
"""Attributes that change from frame to frame, or come from the video; the rest follows from the config."""
ROBOT_TIER = "robot looks at"
"""Tier of events: the robot's fixations."""
GREY_SPREAD = 16
"""Difference between the channels of a pixel up to which it has no colour; compression makes small ones."""


class Viewing:
    """One viewing of a video, frame by frame.

    Attributes:
        footage: The video.
        watcher: Perception and attention.
        mapped: From pixels of the video to those of the robot's image; None before the first frame.
        frames: Number of frames so far.
        total: Number of frames to watch; infinite without ``config.max_minutes``.
        fixations: Fixations so far.
        album: Face patterns so far.
        face_side: Height of the face, pixels of the video; None if unknown.
        names: Of the candidates, the face last.
        rgb: (n, 3) colours of the objects, 0..1.
        visible: (n + 1,) number of frames in which each candidate was detected.
        moves: (n + 1,) number of frames in which it was detected to move.
        sample: One of the robot's images for the figure, (240, 320, 3) uint8 RGB: the first with a face.
        coloured: Whether any image had colours.
        sizes: Widths and heights of the video's images.
        people: All faces; None with the detector templates.
        visible_faces: The faces in the last image, the largest first.
        chosen: The face of interest among them; None where it is not there.
        face_px: Greatest height of the face of interest so far, pixels of the robot's image.
        shots: Cuts and motion of the camera.
        spans: When who was there, and what should be checked.
        camera_moves: Number of frames in which the camera moved.
        sample_faces: (k, 4) x, y, width and height of what is to be blurred in ``sample``, pixels of the robot's image.
    """

    def __init__(self, config: PerceiveConfig):
        """Open the video.

        Raises:
            FootageError: There is no such file, or it is no video.
            ExtraError: The network that finds faces is not installed.
        """
        if config.detector == "yunet":
            model_file()
        self.config, self.names = config, (*candidate_names(config.objects, config.areas_each), "face")
        count = len(self.names)
        attention, album = (np.random.default_rng(seed) for seed in np.random.SeedSequence(config.seed).spawn(2))
        self.footage = Footage(config.video, config.fps)
        table, self.rgb = label_table(config.objects, {}, config.areas_each, config.pixels.colours)
        self._sought = sought_objects(config.objects)
        by_colour = np.array([item.picked is None for item in self._sought])
        areas = FootageAreas(table, by_colour, config.areas_each, config.pixels.colours, config.areas, RATE)
        followed = FollowedFace() if config.detector == "yunet" else None
        perceiver = FootagePerception(config.pixels, areas, Rest(config.rest, count), followed, config.face_follow)
        self.watcher = Watcher(perceiver, config.attention, count - 1, config.shift_frames, attention)
        self.mapped: FrameMap | None = None
        self.fixations = Fixations()
        self.album = FaceAlbum(KEPT, perceiver.pattern_size, album)
        self.frames, self.total = 0, math.inf
        if config.max_minutes is not None:
            self.total = max(1, round(config.max_minutes * 60 * RATE))
        self.face_side: float | None = None
        self.visible = np.zeros(count, int)
        self.moves = np.zeros(count, int)
        self.coloured = False
        self.sizes: set[tuple[int, int]] = set()
        self.sample, self.sample_faces = np.zeros((1, 1, 3), np.uint8), np.zeros((0, 4))
        self.people = People(config.people, RATE, config.face_follow) if config.detector == "yunet" else None
        self.interest = FaceOfInterest(FaceRule.parsed(config.face))
        self.visible_faces: list[Sighting] = []
        self.chosen: Sighting | None = None
        self.face_px = 0.0
        self.shots = Shots(config.shots)
        self.spans = Spans(gap=max(RATE // 2, math.ceil(2 * RATE / (self.footage.fps or RATE))))
        self.camera_moves = 0
        self._chosen_last: list[float] = []  # frame, centre x, y and height of the face of interest, where it was last
        self._faces = 0

    def __repr__(self) -> str:
        """In one line: video, progress and fixations."""
        return f"Viewing({self.footage.path}: {self.frames} frames, {len(self.fixations.all)} fixations)"

    def prepare(self) -> None:
        """Look up the objects that were picked, measure the face for templates, and check that the video can be read.

        Raises:
            FootageError: The video has no image, neither timestamps nor a rate, or not what was picked.
        """
        config, each = self.config, self.config.areas_each
        picked = picked_tables(self.footage, self._sought)
        if picked:
            table, self.rgb = label_table(config.objects, picked, each, config.pixels.colours)
            self.watcher.perceiver.areas.take(table)
        if config.detector == "templates" and config.scale is None:
            self.face_side = face_side(self.footage, config.fit, config.pixels.faces)
        elif not picked:
            deque(islice(self.footage, 2), maxlen=0)

    def see(self, still: Still) -> FrameMap:
        """Perceive and attend for one frame; returns the map from the video's image to the robot's."""
        self.mapped = mapped = self._map(still)
        fresh = still.fresh or self.frames == 0
        first_face = self.visible[-1] == 0
        image = mapped.image(still.image) if fresh else self.sample
        cut = still.cut
        if fresh:
            cut = self._find_faces(still, mapped)
        percept = self.watcher.see(image, still.fresh, cut or self.shots.camera_moves)
        self._check_picks(mapped)
        self.visible += percept.visible
        self.moves += percept.moves
        self.camera_moves += self.shots.camera_moves
        if still.fresh and percept.visible[-1]:
            if self._faces % EVERY == 0:
                self.album.add(self.watcher.perceiver.face_pattern(), self.frames / RATE)
            self._faces += 1
        if self.frames == 0 or (first_face and percept.visible[-1]):
            self.sample, self.sample_faces = image, self._in_image(self.boxes_to_blur(), mapped)
        if still.fresh and self.frames % RATE == 0 and not self.coloured:
            spread = image.max(axis=2) - image.min(axis=2)
            self.coloured = bool(np.percentile(spread, 99) > GREY_SPREAD)
        self.fixations.note(self.watcher, self.frames, mapped)
        self.frames += 1
        return mapped

    def events(self) -> list[Span]:
        """When who was in the image, when it was cut or the camera moved, and where the robot would have looked."""
        owner = self.people.owner if self.people is not None else {}
        named = {f"track {track}": f"person {person}{'' if sure else '?'}" for track, (person, sure) in owner.items()}
        kept = [replace(span, code=named.get(span.code, span.code)) for span in self.spans.all if span.tier != CHECK]
        looks = [
            Span(ROBOT_TIER, self.names[fixation.candidate], fixation.start, fixation.end)
            for fixation in self.fixations.all
        ]
        return kept + looks

    def checks(self) -> list[Span]:
        """What somebody should look at."""
        brief = {LOST: LOST_FRAMES}
        return [
            span for span in self.spans.all if span.tier == CHECK and span.end - span.start >= brief.get(span.code, 1)
        ]

    def boxes_to_blur(self) -> np.ndarray:
        """(k, 4) x, y, width and height of the faces in the last image that are to be blurred, pixels of the video."""
        return self.people.to_blur() if self.people is not None else np.zeros((0, 4))

    def _find_faces(self, still: Still, mapped: FrameMap) -> bool:
        """Find faces, cuts and motion of the camera in a new image; returns whether it follows upon a cut."""
        cut = self.shots.see(still.image) or still.cut
        perceiver, areas = self.watcher.perceiver, self.watcher.perceiver.areas
        if self.people is not None and isinstance(perceiver.faces, FollowedFace):
            self.visible_faces = self.people.see(still.image, self.frames, cut)
            self.chosen = self.interest.choose(self.visible_faces, self.frames, cut)
            perceiver.faces.show(self.chosen, still.image, mapped)
            if self.chosen is not None:
                self.face_px = max(self.face_px, float(self.chosen.smooth[3]) * mapped.scale_y)
            areas.show_faces(self._boxes(mapped), cut, self.shots.shifted)
        else:
            areas.show_faces(self._template_box(), cut, self.shots.shifted)
        self._chosen_last = note_checks(
            self.spans,
            self.frames,
            self.visible_faces,
            self.chosen,
            self.shots,
            cut and self.frames > 0,
            self._chosen_last,
        )
        return cut

    def _check_picks(self, mapped: FrameMap) -> None:
        """Note the objects that are not found where they were picked, when they were: something else has their colours,
        say, or they are worn."""
        areas = self.watcher.perceiver.areas
        for k, sought in enumerate(self._sought):
            if sought.picked is None or self.frames != self.footage.frame_at(sought.picked[0]):
                continue
            if not areas.is_at(k, mapped.to_image(np.array(sought.picked[1:]))):
                self.spans.note(CHECK, f"{sought.name} not found where it was picked", self.frames)

    def _boxes(self, mapped: FrameMap) -> np.ndarray:
        """(k, 4) x, y, width and height of all faces, pixels of the robot's image, the face of interest first."""
        faces = sorted(self.visible_faces, key=lambda face: face is not self.chosen)
        return self._in_image(np.array([face.smooth for face in faces]).reshape(-1, 4), mapped)

    @staticmethod
    def _in_image(boxes: np.ndarray, mapped: FrameMap) -> np.ndarray:
        """Boxes (k, 4) of the video in pixels of the robot's image."""
        corners = mapped.to_image(boxes[:, :2] - 0.5)
        return np.hstack([corners, boxes[:, 2:] * (mapped.scale_x, mapped.scale_y)])

    def _template_box(self) -> np.ndarray:
        perceiver = self.watcher.perceiver
        if not perceiver.fix.detected:
            return np.zeros((0, 4))
        x0, y0, x1, y1 = perceiver.faces.box(perceiver.fix, (IMAGE_HEIGHT, IMAGE_WIDTH))
        return np.array([[x0, y0, x1 - x0, y1 - y0]], float)

    def state(self) -> dict[str, Any]:
        """State from which a viewing of the same config can go on (see ``restore``)."""
        return {"bytes": self._bytes(), **{name: getattr(self, name) for name in STATE}}

    def restore(self, state: dict[str, Any]) -> None:
        """Take over what ``state`` gave.

        Raises:
            CheckpointError: It is no such state, or the video has changed.
        """
        for name in ("bytes", *STATE):
            now = self._bytes() if name == "bytes" else getattr(self, name)
            if name not in state or (now is not None and type(state[name]) is not type(now)):
                raise CheckpointError(f"the checkpoint has no {name} of a viewing; begin anew in another folder")
        if state["bytes"] != self._bytes():
            raise CheckpointError(
                f"{self.footage.path} had {state['bytes']} bytes when it was watched, and has {self._bytes()}; choose "
                "another folder to watch it anew"
            )
        vars(self).update({name: state[name] for name in STATE})

    def _bytes(self) -> int:
        return self.footage.path.stat().st_size

    def _map(self, still: Still) -> FrameMap:
        height, width = still.image.shape[:2]
        if self.mapped is not None and (self.mapped.width, self.mapped.height) == (width, height):
            return self.mapped
        self.sizes.add((width, height))
        aspect, fit, scale = self.footage.aspect, self.config.fit, self.config.scale
        if scale is not None:
            return FrameMap.scaled(width, height, aspect, scale)
        fitted = FrameMap.fitted(width, height, aspect, fit)
        most = largest_scale(self.face_side, fitted.scale_y, self.config.pixels.faces)
        return fitted if most == fitted.scale_y else FrameMap.scaled(width, height, aspect, most)
