"""The last part of ``perceive --looks``: learn from what was kept of the video, and code it."""

from pathlib import Path
from typing import Any

import numpy as np

from jointattn_mj.footage.checks import CAMERA
from jointattn_mj.footage.looks.check import Codings
from jointattn_mj.footage.looks.coding import AWAY, ObservedLooks, code_looks
from jointattn_mj.footage.looks.log import LooksLog
from jointattn_mj.footage.looks.tables import looks_spans, looks_table
from jointattn_mj.footage.reader import RATE
from jointattn_mj.footage.spans import Span
from jointattn_mj.footage.viewing import Viewing
from jointattn_mj.io.parquet import write_parquet
from jointattn_mj.perception.som import SOM


def leave_looks(
    out: Path, log: LooksLog, viewing: Viewing, som: SOM | None, known: Codings | None = None
) -> tuple[dict[str, Any], list[Span]]:
    """Code where the person of interest looks, and write looks.parquet.

    Args:
        out: Folder of the run.
        log: What was kept.
        viewing: The viewing, after its last frame.
        som: The map of faces; None where no face was seen.
        known: What a person has coded, which learning takes for granted.

    Returns:
        Numbers for the summary, and the event tier.

    Raises:
        OutputError: The table cannot be written.
        SeriesError: ``known`` has a code that is no candidate.
    """
    config, start_s = viewing.config.coding, viewing.footage.start_s
    observed, frames = observed_looks(log, viewing, som), log.frames()
    times = start_s + frames / RATE
    labels = None if known is None else known.at(times, (*observed.names, AWAY))
    coded = code_looks(observed, config, labels)
    write_parquet(out / "looks.parquet", looks_table(coded, times))
    return coded.summary(config), looks_spans(coded, frames, viewing.frames)


def observed_looks(log: LooksLog, viewing: Viewing, som: SOM | None) -> ObservedLooks:
    """What was seen so far.

    Args:
        log: What was kept.
        viewing: The viewing.
        som: The map of faces; None where no face was seen.
    """
    config = viewing.config.coding
    cuts = [range(span.start, span.end) for span in viewing.spans.all if (span.tier, span.code) == (CAMERA, "cut")]
    after = np.array([frame for cut in cuts for frame in cut], int)
    return log.looks(som, after, config)
