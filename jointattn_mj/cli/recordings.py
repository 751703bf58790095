"""``jointattn recordings``: one page about coded interaction."""

from typing import Annotated

from jointattn_mj.io.progress import Progress
from jointattn_mj.options import FLAT
from jointattn_mj.recordings.report import ReportOptions, run_report

LESS = "fewer surrogates, a longer step, or fewer tiers"


def recordings(options: Annotated[ReportOptions, FLAT]) -> None:
    """Make one page of a folder of coded interaction: timelines, joint attention, transitions, contingency.

    Takes files of ELAN, BORIS, Datavyu, Observer or INTERACT, or tables with onset and offset. --infant and --partner
    name the tiers of looks. Leaves in --out: report.html (one file to read, print and send), methods.txt to paste,
    report.json, a CSV file for each table, figures/.
    """
    with Progress("reading", unit="surrogates") as shown:
        report = run_report(options, lambda done: shown.add(done, "drawing"))
    print(report.text())
