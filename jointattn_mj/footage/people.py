"""All faces of a video from frame to frame, and which of them are one person.

A track is a face that is followed without a gap; a face that is lost for longer, or a cut, ends it. Tracks become
people by ``likeness``: a new track is compared, over its first sightings, with those people who are not in the image.
Where the answer is neither a clear yes nor a clear no, it is unsure, and said to be.
"""

from dataclasses import dataclass, field
from typing import Annotated, ClassVar

import numpy as np

from jointattn_mj.footage.head import yaw_of
from jointattn_mj.footage.likeness import OTHER, SAME, Appearance, appearance, likeness
from jointattn_mj.footage.yunet import BOX, COLUMNS, LANDMARKS, SCORE, faces_in, faces_near, overlaps
from jointattn_mj.options import Checked, Real, Share, Whole

YAW_BINS = (-30.0, -10.0, 10.0, 30.0)
"""Borders of the views of a person that are remembered, degrees."""
KEPT_SHARE = 0.1
"""Share of each new sighting in what is remembered of a view."""
STRANGE = 0.6
"""Likeness to its own person below which a followed face is perhaps another; one person has .74 over half a turn."""
CROWDED = 1.5
"""Distance of two faces, in face heights, below which positions alone do not tell them apart."""
CUT_WEIGHT = 0.1
"""Weight of a sighting that the border cuts, in judging who it is: the network guesses what lies beyond."""
WHOLE = 0.95
"""Share of a face's box in the image from which the border does not cut it."""
BLURRED_S = 10.0
"""Seconds for which the place of a lost face stays blurred: the network misses faces that are cut by the border, and
people recognise them."""
MOST_PEOPLE = 64
"""Most people of a video that are told apart."""


@dataclass(frozen=True)
class PeopleConfig(Checked):
    """How faces in footage are found, followed and told apart."""

    start_score: Annotated[float, Real("[0.5, 1]")] = 0.75
    """Score with which a face is believed at once. Clear faces have .8 to .95, a skull on a shirt .55."""
    doubtful_score: Annotated[float, Real("[0.5, 1]")] = 0.6
    """Score with which a face is believed after ``doubtful_frames`` frames."""
    doubtful_frames: Annotated[int, Whole("[1, 10000]")] = 10
    """Frames in which a doubtful face must be found, one after the other."""
    keep_score: Annotated[float, Real("[0.5, 1]")] = 0.55
    """Least score of a face that is being followed."""
    scan_every: Annotated[int, Whole("[1, 10000]")] = 8
    """Images from one search of the whole image to the next; known faces are looked for in every image."""
    empty_every: Annotated[int, Whole("[1, 10000]")] = 2
    """The same while there is no face."""
    scan_px: Annotated[int, Whole("[64, 8192]")] = 960
    """Longest side of the image in such a search, pixels; larger images are made smaller for it."""
    window_px: Annotated[int, Whole("[64, 1024]")] = 192
    """Side of the window in which a known face is looked for."""
    window_face_px: Annotated[int, Whole("[16, 512]")] = 80
    """Largest height of the face in the window."""
    gap_s: Annotated[float, Real("[0, 60]")] = 1.0
    """Seconds for which a face may be lost, and is still the same track where it comes back near by."""
    reach: Annotated[float, Real("[0.1, 10]")] = 0.8
    """How far a face may have moved between two images, in face heights."""
    size_follow: Share = 0.2
    """Weight of each image in the smoothed size of a face, from which its pattern is cut."""
    judged_sightings: Annotated[int, Whole("[1, 1000]")] = 8
    """Sightings of a new face from which it is judged who it is; those that the border cuts count less."""
    compare_every: Annotated[int, Whole("[1, 10000]")] = 6
    """Images from one look at what a known person looks like to the next."""

    ADVANCED: ClassVar = (
        "scan_px", "window_px", "window_face_px", "gap_s", "reach", "size_follow", "judged_sightings", "compare_every",
        "doubtful_frames",
    )  # fmt: skip


@dataclass
class Sighting:
    """A face in one image, pixels of the video."""

    track: int
    """Number of the track, from 1."""
    person: int
    """Number of the person, from 1; a guess until the track is judged."""
    sure: bool
    """Whether that is known."""
    judged: bool
    """Whether the face was seen for long enough to say so."""
    face: np.ndarray
    """(15,) box, landmarks and score, as of ``yunet``."""
    smooth: np.ndarray
    """(4,) x, y, width and height of the smoothed box."""
    yaw_deg: float
    """Yaw against the line to the camera, positive to the right of the image; NaN where it cannot be measured."""
    yaw_error_deg: float
    """Its expected error."""

    @property
    def score(self) -> float:
        """Of the detector, 0 to 1."""
        return float(self.face[SCORE])

    @property
    def centre(self) -> np.ndarray:
        """Centre of the smoothed box, (2,) pixels."""
        return np.asarray(self.smooth[:2] + self.smooth[2:] / 2)


@dataclass
class Track:
    """A face that is followed."""

    number: int
    face: np.ndarray
    smooth: np.ndarray
    last: int
    """Frame in which it was found last."""
    sightings: int = 1
    believed: bool = False
    person: int = 0
    """0 while nobody knows."""
    sure: bool = False
    judged: bool = False
    odd: int = 0
    """Looks in a row at which it was not like its person."""
    weighed: float = 0.0
    """Sum of the weights of the sightings from which it is judged."""
    evidence: dict[int, list[tuple[float, float]]] = field(default_factory=dict)
    """Likeness to each person who may be meant, and its weight, by sighting."""


@dataclass
class Person:
    """Somebody in the video."""

    number: int
    views: dict[int, Appearance] = field(default_factory=dict)
    """What the person looks like, by bin of yaw."""
    perhaps: int = 0
    """Person of whom it is unsure whether this is another; 0 for none."""

    def likeness(self, appeared: Appearance) -> float:
        """How alike an appearance is to the most similar view, 0 to 1."""
        return max((likeness(view, appeared) for view in self.views.values()), default=0.0)

    def learn(self, appeared: Appearance, yaw_deg: float) -> None:
        """Remember an appearance."""
        view = 0 if np.isnan(yaw_deg) else 1 + int(np.searchsorted(YAW_BINS, yaw_deg))
        old = self.views.get(view)
        self.views[view] = appeared if old is None else Appearance(*map(_mixed, old, appeared))


def _mixed(old: np.ndarray, new: np.ndarray) -> np.ndarray:
    if not new.any() or not old.any():
        return new if new.any() else old
    mixed = (1 - KEPT_SHARE) * old + KEPT_SHARE * new
    return np.asarray(mixed / np.linalg.norm(mixed))


def _middle_visible(faces: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    """Whether the middle of each face lies in the image, (n,) bool. The network completes faces that are cut by the
    border; of one that is mostly beyond it, it guesses place and size."""
    middle = faces[:, :2] + faces[:, 2:4] / 2
    return np.asarray((middle >= 0).all(axis=1) & (middle < (shape[1], shape[0])).all(axis=1))


def _weighed_mean(alike: list[tuple[float, float]]) -> float:
    """Mean of values with their weights."""
    values, weights = np.transpose(alike)
    return float(np.average(values, weights=weights))


def _share_visible(box: np.ndarray, shape: tuple[int, ...]) -> float:
    """Share of a box (4,) that lies in the image."""
    shown = np.minimum(box[:2] + box[2:], (shape[1], shape[0])) - np.maximum(box[:2], 0)
    return float(np.prod(np.maximum(shown, 0) / box[2:]))


class People:
    """Follows all faces of a video. It can be pickled.

    Attributes:
        tracks: Faces that are followed now.
        people: All people so far, by number.
        owner: Person and whether that is sure, of each track that was believed.
        images: Of each such track the number of its images, and its first and last frame.
    """

    def __init__(self, config: PeopleConfig, rate: float, follow: float):
        """Make it for a new video.

        Args:
            config: Options.
            rate: Frames a second.
            follow: Weight of each image in the smoothed location of a face.
        """
        self.config = config
        self.tracks: list[Track] = []
        self.people: dict[int, Person] = {}
        self.owner: dict[int, tuple[int, bool]] = {}
        self.images: dict[int, tuple[int, int, int]] = {}
        self._ended: list[Track] = []
        self._blurred = round(BLURRED_S * rate)
        self._gap, self._follow = round(config.gap_s * rate), follow
        self._until_scan, self._number, self._images = 0, 0, 0

    def see(self, image: np.ndarray, frame: int, cut: bool) -> list[Sighting]:
        """Find and follow the faces of one image.

        Args:
            image: (h, w, 3) uint8 BGR, pixels of the video.
            frame: Number of the frame.
            cut: Whether it follows upon a cut, so that no face need be where it was.

        Returns:
            The faces that are believed, the largest first.
        """
        if cut:
            self.tracks.clear()
            self._ended.clear()
        self._images += 1
        faces = self._find(image, cut)
        self._assign(image, faces, frame)
        self._ended = [track for track in self._ended if frame - track.last <= self._blurred]
        self._ended += [track for track in self.tracks if track.believed and not self._goes_on(track, frame)]
        self.tracks = [track for track in self.tracks if self._goes_on(track, frame)]
        now = [track for track in self.tracks if track.last == frame]
        for track in now:
            self._believe(track)
        sightings = [self._sighting(image, track, frame) for track in now if track.believed]
        return sorted(sightings, key=lambda sighting: -float(sighting.smooth[3]))

    def to_blur(self) -> np.ndarray:
        """(k, 4) x, y, width and height of every face that is followed, believed or not, or was lost a moment ago."""
        return np.array([track.smooth for track in (*self.tracks, *self._ended)]).reshape(-1, 4)

    def _goes_on(self, track: Track, frame: int) -> bool:
        return frame - track.last <= (self._gap if track.believed else 0)

    def _believe(self, track: Track) -> None:
        config, score = self.config, track.face[SCORE]
        if not track.believed and (score >= config.start_score or track.sightings >= config.doubtful_frames):
            track.believed = True

    def _find(self, image: np.ndarray, cut: bool) -> np.ndarray:
        """The faces of an image: known ones in windows, and now and then, or where one is lost, all."""
        config, faces = self.config, np.zeros((0, COLUMNS), np.float32)
        if self.tracks:
            boxes = np.array([track.face[BOX] for track in self.tracks])
            near = faces_near(image, boxes, config.keep_score, config.window_px, config.window_face_px)
            near = near[~np.isnan(near[:, 0])]
            lost = len(near) < len(self.tracks)
            for face in near[np.argsort(-near[:, SCORE], kind="stable")]:
                if not len(faces) or overlaps(face[BOX], faces[:, BOX]).max() < 0.4:
                    faces = np.vstack([faces, face])
            if lost:
                self._until_scan = min(self._until_scan, config.empty_every)
        self._until_scan -= 1
        if cut or self._until_scan < 0:
            for face in faces_in(image, min(config.doubtful_score, config.start_score), config.scan_px):
                if not len(faces) or overlaps(face[BOX], faces[:, BOX]).max() < 0.2:
                    faces = np.vstack([faces, face])
            self._until_scan = (config.scan_every if len(faces) else config.empty_every) - 1
        return np.asarray(faces[_middle_visible(faces, image.shape)])

    def _assign(self, image: np.ndarray, faces: np.ndarray, frame: int) -> None:
        """Give each face to the track that it continues, or begin one."""
        costs = np.full((len(self.tracks), len(faces)), np.inf)
        centres = faces[:, :2] + faces[:, 2:4] / 2
        for i, track in enumerate(self.tracks):
            high = float(track.face[3])
            off = np.hypot(*(centres - track.face[:2] - track.face[2:4] / 2).T) / high
            ratio = np.abs(np.log(faces[:, 3] / high))
            reach = self.config.reach * min(1.0 + 0.1 * (frame - track.last), 2.0)
            costs[i] = np.where((off < reach) & (ratio < np.log(1.6)), off + ratio, np.inf)
        for i, k in self._contested(costs):
            person = self.people.get(self.tracks[i].person)
            if person is not None and person.views:
                costs[i, k] += 4 * (1 - person.likeness(appearance(image, faces[k])))
        taken = set()
        if costs.size:
            from scipy.optimize import linear_sum_assignment  # takes .2 s to import

            for i, k in zip(*linear_sum_assignment(np.where(np.isinf(costs), 1e6, costs)), strict=True):
                if np.isfinite(costs[i, k]):
                    self._follow_on(self.tracks[i], faces[k], frame)
                    taken.add(int(k))
        for k, face in enumerate(faces):
            if k not in taken and face[SCORE] >= self.config.doubtful_score:
                self._number += 1
                self.tracks.append(Track(self._number, face, face[BOX].copy(), frame))

    def _contested(self, costs: np.ndarray) -> list[tuple[int, int]]:
        """Pairs of track and face where a track has several faces to choose from, or a face several tracks."""
        fits = np.isfinite(costs)
        several = fits & ((fits.sum(axis=0, keepdims=True) > 1) | (fits.sum(axis=1, keepdims=True) > 1))
        return [(int(i), int(k)) for i, k in np.argwhere(several)]

    def _follow_on(self, track: Track, face: np.ndarray, frame: int) -> None:
        far = float(np.hypot(*(face[:2] + face[2:4] / 2 - track.smooth[:2] - track.smooth[2:] / 2)))
        follow = 1.0 if track.last < frame - 3 or far > 0.25 * float(face[3]) else self._follow
        size = track.smooth[2:] + self.config.size_follow * (face[2:4] - track.smooth[2:])
        centre = track.smooth[:2] + track.smooth[2:] / 2
        centre = centre + follow * (face[:2] + face[2:4] / 2 - centre)
        track.smooth = np.concatenate([centre - size / 2, size])
        track.face, track.last = face, frame
        track.sightings += 1

    def _sighting(self, image: np.ndarray, track: Track, frame: int) -> Sighting:
        yaw, error = yaw_of(track.face[LANDMARKS].reshape(5, 2), float(track.face[3]))
        if not track.judged:
            whole = _share_visible(track.face[BOX], image.shape) >= WHOLE
            self._judge(track, appearance(image, track.face), 1.0 if whole else CUT_WEIGHT, yaw, frame)
        elif self._images % self.config.compare_every == 0:
            self._compare(track, appearance(image, track.face), yaw)
        self.owner[track.number] = (track.person, track.sure)
        count, first, _ = self.images.get(track.number, (0, frame, frame))
        self.images[track.number] = count + 1, first, frame
        return Sighting(track.number, track.person, track.sure, track.judged, track.face, track.smooth, yaw, error)

    def _judge(self, track: Track, appeared: Appearance, weight: float, yaw: float, frame: int) -> None:
        """Find out who a new face is."""
        present = {other.person for other in self.tracks if other is not track and other.last == frame}
        absent = [person for number, person in self.people.items() if number not in present]
        if not absent:
            self._is_new(track, appeared, yaw, True)
            return
        for person in absent:
            track.evidence.setdefault(person.number, []).append((person.likeness(appeared), weight))
        track.weighed += weight
        likely = sorted(((_weighed_mean(alike), number) for number, alike in track.evidence.items()), reverse=True)
        (best, number), second = likely[0], likely[1][0] if len(likely) > 1 else 0.0
        track.person = number if best >= SAME else 0
        if track.weighed < self.config.judged_sightings:
            return
        track.evidence.clear()
        if best >= SAME and best - second > 0.03:
            track.judged = track.sure = True
            self.tracks = [other for other in self.tracks if other is track or other.person != number]  # lost elsewhere
        else:
            self._is_new(track, appeared, yaw, best <= OTHER)
            if best > OTHER and track.person:
                self.people[track.person].perhaps = number

    def _is_new(self, track: Track, appeared: Appearance, yaw: float, sure: bool) -> None:
        track.judged, track.sure = True, sure
        if len(self.people) == MOST_PEOPLE:
            track.person, track.sure = 0, False
            return
        track.person = len(self.people) + 1
        person = self.people[track.person] = Person(track.person)
        person.learn(appeared, yaw)

    def _compare(self, track: Track, appeared: Appearance, yaw: float) -> None:
        """Learn more of a person, or notice that a track has passed to somebody else."""
        person = self.people.get(track.person)
        if person is None:
            return
        alike = person.likeness(appeared)
        track.odd = track.odd + 1 if alike < STRANGE else 0
        if track.odd >= 3:
            track.judged = track.sure = False
            track.odd, track.person, track.sightings, track.weighed = 0, 0, 1, 0.0
            self._number += 1
            track.number = self._number
        elif track.odd == 0 and track.sure and not self._crowded(track):
            person.learn(appeared, yaw)

    def _crowded(self, track: Track) -> bool:
        """Whether another face is so near that the two could be mixed up."""
        centre, high = track.smooth[:2] + track.smooth[2:] / 2, CROWDED * float(track.smooth[3])
        others = (other.smooth for other in self.tracks if other is not track)
        return any(float(np.hypot(*(other[:2] + other[2:] / 2 - centre))) < high for other in others)
