"""How long a machine takes from an image to a decision, and what of the images it cannot use."""

from dataclasses import dataclass, field

import numpy as np

LONGEST_MS = 2000


@dataclass
class CameraCount:
    """Counts of a session with a camera.

    Attributes:
        images: Images that the camera has given.
        images_lost: Those that were followed by another before they were taken up, without those of a pause.
        frames_lost: Frames in which the robot saw no new image because the machine was late.
        seconds: Time for which the camera was open, up to its last image.
    """

    images: int = 0
    images_lost: int = 0
    frames_lost: int = 0
    seconds: float = 0.0


@dataclass
class Latency:
    """Counts of latencies by milliseconds.

    Attributes:
        counts: (LONGEST_MS + 1,) how many took so many milliseconds; the last one those that took longer.
    """

    counts: np.ndarray = field(default_factory=lambda: np.zeros(LONGEST_MS + 1, np.int64))

    def add(self, seconds: float) -> None:
        """Count one."""
        self.counts[min(max(round(1000 * seconds), 0), LONGEST_MS)] += 1

    def quantile(self, share: float) -> float | None:
        """Milliseconds below which so many lie; None without any."""
        total = int(self.counts.sum())
        return float(np.searchsorted(np.cumsum(self.counts), share * total)) if total else None
