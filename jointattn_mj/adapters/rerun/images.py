"""The robot's images in a log: as H.264 where ffmpeg can encode it, else as JPEG, which takes more space."""

import cv2
import numpy as np
import rerun as rr

from jointattn_mj.adapters.rerun.entities import columns_of
from jointattn_mj.scene.caregiver import FRAME_S
from jointattn_mj.scene.model import IMAGE_HEIGHT, IMAGE_WIDTH
from jointattn_mj.video.stream import Unit, VideoEncoder, can_encode

JPEG_QUALITY = 80
"""0 to 100; an image takes some 5 KB."""


class Images:
    """Writes images to one entity, those of a second together."""

    def __init__(self, log: rr.RecordingStream, path: str):
        self._log, self._path = log, path
        self._encoder = VideoEncoder(IMAGE_HEIGHT, IMAGE_WIDTH, 1 / FRAME_S) if can_encode() else None
        self._frames: list[int] = []
        self._units: list[Unit] = []
        if self._encoder is not None:
            log.log(path, rr.VideoStream(codec=rr.VideoCodec.H264), static=True)

    def add(self, frame: int, image: np.ndarray) -> None:
        """Add the image of a frame.

        Args:
            frame: Its number in the session.
            image: uint8 (240, 320, 3) RGB.

        Raises:
            VideoError: ffmpeg has given up.
        """
        if self._encoder is None:
            flags = [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY]
            _, jpeg = cv2.imencode(".jpg", cv2.cvtColor(image, cv2.COLOR_RGB2BGR), flags)
            self._log.log(self._path, rr.EncodedImage(contents=jpeg.tobytes(), media_type="image/jpeg"))
            return
        self._encoder.add(image)
        self._frames.append(frame)
        self._units += self._encoder.take()
        if len(self._units) >= 1 / FRAME_S:
            self._write()

    def finish(self) -> None:
        """Write the images that are left."""
        if self._encoder is not None:
            self._units += self._encoder.finish()
            self._write()

    def _write(self) -> None:
        units, self._units = self._units, []
        frames, self._frames = self._frames[: len(units)], self._frames[len(units) :]
        if units:
            samples, keys = [unit.sample for unit in units], [unit.key for unit in units]
            columns = rr.VideoStream.columns(sample=samples, is_keyframe=keys)
            self._log.send_columns(self._path, columns_of(frames), columns)
