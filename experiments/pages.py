"""Write the values of a report into the claims' pages: ``python -m experiments.pages out/claims``.

Each claim's ``README.md`` has a table of all values, and the ``README.md`` of this folder a table of verdicts. Both
come from ``claims.json``, which ``jointattn experiment report`` writes. Claims without trials there keep their values.
"""

import json
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

import tyro

from jointattn_mj.errors import OutputError
from jointattn_mj.sweeps.claim import Verdict
from jointattn_mj.sweeps.report import table_of

from .registry import REGISTRY

HERE = Path(__file__).parent
BEGIN, END = "<!-- values: written by python -m experiments.pages -->", "<!-- end of values -->"


def page_of(claim_id: str) -> Path:
    """The page of a claim."""
    return HERE / REGISTRY.entries[claim_id].folder / "README.md"


def verdicts(page: str) -> list[Verdict]:
    """Verdicts in the table of values of a page."""
    table = page.partition(BEGIN)[2].partition(END)[0]
    cells = [re.split(r"(?<!\\)\|", line)[-2] for line in table.splitlines() if line.startswith("| ")]
    return [Verdict(cell.partition(":")[0].strip()) for cell in cells[1:]]


def with_values(page: str, findings: Sequence[Mapping[str, Any]]) -> str:
    """A claim's page with other values."""
    return _between(page, table_of(findings))


def index() -> str:
    """Table of all claims with their verdicts, from their pages."""
    lines = ["| | claim | verdict |", "|---|---|---|"]
    for claim_id, entry in REGISTRY.entries.items():
        verdict = Verdict.of_all(verdicts(page_of(claim_id).read_text("utf-8")))
        lines.append(f"| {claim_id} | [{entry.title}]({entry.folder}/README.md) | {verdict} |")
    return "\n".join(lines) + "\n"


def _between(page: str, table: str) -> str:
    before, _, rest = page.partition(BEGIN)
    return f"{before}{BEGIN}\n\n{table}\n{END}{rest.partition(END)[2]}"


def main(folder: Annotated[Path, tyro.conf.Positional]) -> None:
    """Write the values of a report into the claims' pages.

    Args:
        folder: Folder with ``claims.json``.
    """
    try:
        claims = json.loads((folder / "claims.json").read_text("utf-8"))
    except OSError as error:
        raise OutputError(f"no claims.json in {folder}; run `jointattn experiment report {folder}`") from error
    for claim in claims:
        if claim["findings"]:
            page = page_of(claim["id"])
            page.write_text(with_values(page.read_text("utf-8"), claim["findings"]), "utf-8")
    readme = HERE / "README.md"
    readme.write_text(_between(readme.read_text("utf-8"), index()), "utf-8")


if __name__ == "__main__":
    tyro.cli(main)
