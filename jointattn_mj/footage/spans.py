"""Spans of time in which something is so: people in the image, what to check, cuts. Events for coding programs."""

import csv
from dataclasses import dataclass
from pathlib import Path

from jointattn_mj.footage.reader import RATE
from jointattn_mj.io.files import write_whole

MOST = 20_000
"""Most spans that are kept."""
COLUMNS = ("onset_s", "offset_s", "tier", "code", "score")


@dataclass
class Span:
    """Frames from ``start`` to ``end``, the latter exclusive, of one code of one tier."""

    tier: str
    code: str
    start: int
    end: int
    total: float = 0.0
    """Sum of the scores of ``frames`` frames."""
    frames: int = 0

    @property
    def score(self) -> float | None:
        """Mean score; None without any."""
        return self.total / self.frames if self.frames else None


class Spans:
    """Collects spans, frame by frame. It can be pickled.

    Attributes:
        all: Spans so far, by their beginning.
    """

    def __init__(self, gap: int):
        """Make it; what is so again within ``gap`` frames was so in between."""
        self.all: list[Span] = []
        self._gap = gap
        self._open: dict[str, int] = {}

    def note(self, tier: str, code: str, frame: int, score: float | None = None) -> None:
        """Say that something is so in a frame.

        Args:
            tier: What kind of thing.
            code: Which.
            frame: Number of the frame.
            score: How sure that is, 0 to 1; None where that has no meaning.
        """
        key = f"{tier}: {code}"
        index = self._open.get(key, -1)
        if index < 0 or frame - self.all[index].end > self._gap:
            if len(self.all) >= MOST:
                return
            self._open[key] = index = len(self.all)
            self.all.append(Span(tier, code, frame, frame))
        span = self.all[index]
        span.end = frame + 1
        if score is not None:
            span.total, span.frames = span.total + score, span.frames + 1


def write_spans(path: Path, spans: list[Span], start_s: float) -> None:
    """Write spans as a table of events: onset, offset, tier, code, score.

    Args:
        path: A CSV file.
        spans: In any order.
        start_s: Time of the first frame, s.

    Raises:
        OutputError: It cannot be written.
    """

    def write(to: Path) -> None:
        with to.open("w", newline="", encoding="utf-8") as file:
            rows = csv.writer(file, lineterminator="\n")
            rows.writerow(COLUMNS)
            for span in sorted(spans, key=lambda span: (span.start, span.tier, span.code)):
                score = "" if span.score is None else f"{span.score:.3f}"
                onset, offset = (f"{start_s + at / RATE:.3f}" for at in (span.start, span.end))
                rows.writerow((onset, offset, span.tier, span.code, score))

    write_whole(path, write)
