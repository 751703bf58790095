"""The page of coded interaction for a watched video: where the person looks, beside where the robot would look."""

from pathlib import Path

from jointattn_mj.errors import SeriesError
from jointattn_mj.footage.looks.coding import AWAY, UNSEEN, UNSURE
from jointattn_mj.footage.looks.tables import TIER
from jointattn_mj.footage.viewing import ROBOT_TIER
from jointattn_mj.recordings.report import PAGE, ReportOptions, run_report

FOLDER = "page"
"""Folder of the page in that of the results."""
SURROGATES = 200
"""Surrogates behind the page's p-values; ``jointattn recordings`` draws more, and resamples for intervals."""


def write_looks_page(out: Path, why_not: str | None) -> dict[str, str | None]:
    """Make the page from ``events.csv``, in place of an earlier one.

    Args:
        out: Folder of the results.
        why_not: Why looks were not coded, so that there is nothing to show; None if they were.

    Returns:
        For the summary: the ``page``, or ``why_no_page``.

    Raises:
        OutputError: It cannot be written.
    """
    (out / FOLDER / PAGE).unlink(missing_ok=True)
    if why_not is not None:
        return {"page": None, "why_no_page": why_not}
    try:
        run_report(
            ReportOptions(
                out / "events.csv",
                out=out / FOLDER,
                title="Looks in a video",
                infant=ROBOT_TIER,
                partner=TIER,
                tiers=(ROBOT_TIER, TIER),
                nowhere=(AWAY, UNSURE, UNSEEN),
                surrogates=SURROGATES,
                resamples=0,
            )
        )
    except SeriesError as error:
        return {"page": None, "why_no_page": str(error)}
    return {"page": f"{FOLDER}/{PAGE}", "why_no_page": None}
