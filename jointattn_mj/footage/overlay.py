"""One image of the overlay video: the video with the percept drawn on it, the attended candidate, and all interest."""

import numpy as np

from jointattn_mj.footage.blurring import blurred
from jointattn_mj.footage.followed import PATTERN_HEIGHTS
from jointattn_mj.footage.frame_map import IMAGE_HEIGHT, IMAGE_WIDTH, FrameMap
from jointattn_mj.footage.log import PerceptLog
from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.footage.watcher import Watcher
from jointattn_mj.footage.yunet import LANDMARKS
from jointattn_mj.gaze_following.attention import AttentionConfig
from jointattn_mj.gaze_following.film.interest import InterestPanel
from jointattn_mj.gaze_following.film.overlay import BAR, STATUS
from jointattn_mj.video.paint import GREY, GROUND, PERSON, WHITE, Box, Colour, disc, ink_of, lines, shade, write
from jointattn_mj.video.percepts import SCALE, PerceptInk, caption, location

WIDTH, HEIGHT = 672, 688
_EYE = Box(16, 44, IMAGE_WIDTH * SCALE, IMAGE_HEIGHT * SCALE)
_INTEREST = Box(16, 532, 640, 148)


class FootageOverlay:
    """Draws images, uint8 (688, 672, 3)."""

    def __init__(self, names: tuple[str, ...], rgb: np.ndarray, attention: AttentionConfig, blur_faces: bool = False):
        """Draw what stays the same.

        Args:
            names: Of the objects and, last, the face.
            rgb: (n, 3) colours of the objects, 0..1.
            attention: Settings that bound the interest.
            blur_faces: Make faces unrecognisable.
        """
        self._blur = blur_faces
        self._names = names
        self._inks: list[Colour] = [*map(ink_of, rgb), PERSON]
        self._percept = PerceptInk(self._inks)
        self._blank = blank = np.full((HEIGHT, WIDTH, 3), GROUND, np.uint8)
        write(blank, _EYE.x, 10, "What the robot would look at", WHITE, 22, True)
        self._interest = InterestPanel(blank, _INTEREST, names, self._inks, attention, person=False)
        self._canvas = blank.copy()

    def compose(self, video: np.ndarray, mapped: FrameMap, viewing: Viewing, log: PerceptLog) -> np.ndarray:
        """The image of this frame, uint8 (688, 672, 3); it is overwritten by the next one.

        Args:
            video: The video's image, (h, w, 3) uint8 BGR.
            mapped: From pixels of the video to those of the robot's image.
            viewing: Has just perceived the frame.
            log: Holds the frames so far.
        """
        canvas, watcher = self._canvas, viewing.watcher
        np.copyto(canvas, self._blank)
        seconds = max(0, log.frames - 1) / RATE
        write(canvas, WIDTH - 16, 12, f"{int(seconds // 60):02d}:{seconds % 60:04.1f}", WHITE, 20, align="right")
        area = _EYE.of(canvas)
        area[:] = mapped.image(blurred(video, viewing.boxes_to_blur()) if self._blur else video, SCALE)
        above = area[:-BAR]
        self._draw_people(above, mapped, viewing)
        if viewing.chosen is not None:
            self._percept.face_half_px = PATTERN_HEIGHTS / 2 * float(viewing.chosen.smooth[3]) * mapped.scale_y
        if watcher.percept is not None:
            self._percept.draw(above, watcher.percept, self._fixated(watcher), watcher.perceiver.motion)
        if watcher.goal is not None:
            self._draw_shift(above, watcher, watcher.goal)
        self._draw_status(area, watcher)
        self._interest.draw(canvas, log)
        return canvas

    @staticmethod
    def _fixated(watcher: Watcher) -> int | None:
        return watcher.attended if watcher.goal is None else None

    @staticmethod
    def _draw_people(area: np.ndarray, mapped: FrameMap, viewing: Viewing) -> None:
        """Draw the box of each face, with the number of the person, and where the head points."""
        for face in viewing.visible_faces:
            x, y, wide, high = face.smooth
            corners = np.array([(x, y), (x + wide, y), (x + wide, y + high), (x, y + high), (x, y)])
            box = location(mapped.to_image(corners - 0.5))
            ink = PERSON if face is viewing.chosen else GREY
            lines(area, [box], ink, 1)
            who = f"{face.person}{'' if face.sure else '?'}" if face.person else "?"
            caption(area, np.array([box[:, 0].mean(), box[0, 1] - 26]), who, ink)
            if not np.isnan(face.yaw_deg):
                nose = location(mapped.to_image(face.face[LANDMARKS].reshape(5, 2)[2] - 0.5))
                end = nose + np.array([np.sin(np.radians(face.yaw_deg)) * np.ptp(box[:, 1]), 0.0])
                lines(area, [np.stack([nose, end])], ink, 3)

    def _draw_shift(self, area: np.ndarray, watcher: Watcher, goal: int) -> None:
        """Draw a line from the candidate that was attended to the next one, ``goal``."""
        percept = watcher.percept
        if percept is None or not percept.visible[goal]:
            return
        end = location(percept.px[goal])
        disc(area, end, 12, self._inks[goal], 2)
        if watcher.attended is not None and percept.visible[watcher.attended]:
            lines(area, [np.stack([location(percept.px[watcher.attended]), end])], self._inks[goal], 2)

    def _draw_status(self, area: np.ndarray, watcher: Watcher) -> None:
        """Write one line on what is attended to."""
        bar = area[-BAR:]
        shade(bar, GROUND, 0.88)
        if watcher.goal is not None:
            x = write(bar, 12, 7, "shifts its attention to", WHITE, STATUS) + 7
            write(bar, x, 7, self._names[watcher.goal], self._inks[watcher.goal], STATUS, True)
        elif watcher.attended is None:
            write(bar, 12, 7, "looks at nothing in particular yet", GREY, STATUS)
        else:
            x = write(bar, 12, 7, "looks at", WHITE, STATUS, True) + 7
            x = write(bar, x, 7, self._names[watcher.attended], self._inks[watcher.attended], STATUS, True) + 7
            if watcher.percept is not None and not watcher.percept.visible[watcher.attended]:
                write(bar, x, 7, "(not visible now)", GREY, STATUS)
