"""Reports of stored trials: one page to read, and tables for programs. The same trials give the same bytes."""

import csv
import io
import json
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml
from matplotlib.figure import Figure

from jointattn_mj.errors import OutputError, SweepError
from jointattn_mj.io.files import alone, write_whole
from jointattn_mj.io.page import data_uri, drawn, page
from jointattn_mj.io.progress import count
from jointattn_mj.io.provenance import plain
from jointattn_mj.io.results import without_nan
from jointattn_mj.sweeps.claim import Claim, Comparison, Verdict
from jointattn_mj.sweeps.registry import Entry, Registry
from jointattn_mj.sweeps.run import command
from jointattn_mj.sweeps.store import Store, Stored

FEWEST = 5
"""Runs below which the verdict is undecided, if the claim asks for more."""


@dataclass(frozen=True)
class Chapter:
    """The part of the report on one claim."""

    entry: Entry
    findings: Sequence[Comparison] = ()
    figures: Mapping[str, Figure] = field(default_factory=dict)
    seeds: Mapping[str, Sequence[int]] = field(default_factory=dict)
    """Stored seeds of every setting; an empty list if there are none."""
    configs: Mapping[str, Any] = field(default_factory=dict)
    """Config of every setting as plain data."""
    commands: Sequence[str] = ()
    """Command lines that compute these trials."""
    versions: Sequence[Mapping[str, str]] = ()
    film: Path | None = None
    notes: Sequence[str] = ()
    """Remarks on the trials, such as how many failed."""
    trouble: Sequence[str] = ()
    """Errors of the analysis."""

    def __repr__(self) -> str:
        return f"Chapter({self.entry.id}: {self.runs} trials; {self.tally or 'no findings'})"

    @property
    def verdict(self) -> Verdict:
        """Verdict of all findings together."""
        return Verdict.of_all(finding.verdict for finding in self.findings)

    @property
    def tally(self) -> str:
        """Number of findings by verdict, such as ``3 reproduced, 1 undecided``."""
        given = [finding.verdict for finding in self.findings]
        return ", ".join(f"{given.count(verdict)} {verdict}" for verdict in Verdict if verdict in given)

    @property
    def runs(self) -> int:
        """Number of stored trials."""
        return sum(map(len, self.seeds.values()))


def write_report(registry: Registry, ids: Sequence[str], folder: Path) -> Path:
    """Write report.html, claims.json, claims.csv, claims.md and figures/ into a folder of trials.

    Args:
        registry: All claims.
        ids: Ids of the claims to report on; those without trials are listed as not run.
        folder: The folder of trials.

    Returns:
        Path of report.html.

    Raises:
        OutputError: The folder is missing, has no trials of these claims, or cannot be written; or another report is
            being written there.
        SweepError: An analysis failed; the rest of the report has been written.
    """
    chapters = [chapter(registry, claim, Store(folder)) for claim in ids]
    if not any(chapter.runs for chapter in chapters):
        raise OutputError(f"{folder} holds no trials of {', '.join(ids)}; run some with `{command(['ID'], folder)}`")
    busy = f"another process writes a report into {folder}; wait until it has ended"
    with alone(folder / ".report.lock", folder, busy):
        _write_all(chapters, folder)
    trouble = [f"{chapter.entry.id}: {error}" for chapter in chapters for error in chapter.trouble]
    if trouble:
        raise SweepError(f"{folder / 'report.html'} is written, but not all of it: {'; '.join(trouble)}")
    return folder / "report.html"


def _write_all(chapters: Sequence[Chapter], folder: Path) -> None:
    images = {chapter.entry.id: _save(chapter, folder / "figures") for chapter in chapters}
    tables = {
        "claims.json": json.dumps(without_nan(list(map(_facts, chapters))), indent=1, ensure_ascii=False) + "\n",
        "claims.csv": _csv(chapters),
        "claims.md": _markdown(chapters),
        "report.html": _page(chapters, images, folder),
    }
    for name, text in tables.items():
        _write(folder / name, text.encode())


def chapter(registry: Registry, claim_id: str, store: Store) -> Chapter:
    """Read and analyse the trials of one claim. The claim is imported only if it has trials.

    Args:
        registry: All claims.
        claim_id: Id of the claim.
        store: Folder of trials.
    """
    entry = registry.entries[claim_id]
    if not store.known(claim_id):
        return Chapter(entry)
    claim = registry[claim_id]
    stored, trouble = store.read(claim), []
    findings: Sequence[Comparison] = ()
    figures: Mapping[str, Figure] = {}
    try:
        findings = claim.analyse(stored.trials)
    except Exception as error:
        trouble.append(f"analyse: {type(error).__name__}: {error}")
    try:
        figures = claim.draw(stored.trials)
    except Exception as error:
        trouble.append(f"draw: {type(error).__name__}: {error}")
    seeds = {name: [trial.seed for trial in stored.trials.get(name, ())] for name in claim.settings}
    return Chapter(
        entry=entry,
        findings=[weighed(finding, claim, max(map(len, seeds.values()))) for finding in findings],
        figures=figures,
        seeds=seeds,
        configs={name: plain(setting.config) for name, setting in claim.settings.items()},
        commands=commands(claim, seeds, store.folder),
        versions=stored.versions,
        film=claim.film if claim.film is not None and claim.film.exists() else None,
        notes=_notes(stored, store.failures(claim_id)),
        trouble=trouble,
    )


def weighed(finding: Comparison, claim: Claim, runs: int) -> Comparison:
    """The finding, with the verdict undecided if it rests on too few runs.

    Args:
        finding: The finding.
        claim: Its claim.
        runs: The largest number of runs that any setting has.
    """
    enough = min(FEWEST, max(setting.runs for setting in claim.settings.values()))
    n = runs if finding.ours is None else min(finding.ours.n, runs)
    if n >= enough or finding.verdict in (Verdict.EXTENSION, Verdict.UNDECIDED):
        return finding
    return replace(finding, verdict=Verdict.UNDECIDED, note=f"too few to say: {count(n, 'run')}")


def commands(claim: Claim, seeds: Mapping[str, Sequence[int]], folder: Path) -> list[str]:
    """Command lines that compute exactly these trials.

    Args:
        claim: The claim.
        seeds: Seeds of each setting.
        folder: Folder of results.
    """
    wanted = {name: _ranges(stored) for name, stored in seeds.items() if stored}
    usual = {
        name: [range(claim.first_seed, claim.first_seed + setting.runs)] for name, setting in claim.settings.items()
    }
    if wanted == {name: ranges for name, ranges in usual.items() if ranges[0]}:
        return [command([claim.id], folder)]
    groups: dict[tuple[int, int], list[str]] = {}
    for name, ranges in wanted.items():
        for span in ranges:
            groups.setdefault((span.start, len(span)), []).append(name)
    lines = []
    for (first, runs), names in groups.items():
        every = names == list(claim.settings)
        seed = None if first == claim.first_seed else first
        meant: Sequence[str | None] = [None] if every else names
        lines += [command([claim.id], folder, setting=name, seed=seed, runs=runs) for name in meant]
    return lines


def _ranges(seeds: Sequence[int]) -> list[range]:
    ranges: list[range] = []
    for seed in seeds:
        if ranges and seed == ranges[-1].stop:
            ranges[-1] = range(ranges[-1].start, seed + 1)
        else:
            ranges.append(range(seed, seed + 1))
    return ranges


def _notes(stored: Stored, failures: Sequence[Mapping[str, Any]]) -> list[str]:
    notes = []
    if failures:
        notes.append(f"Trials that failed: {len(failures)}; the same command tries them again")
    unread = [failure["damaged"].name for failure in failures if "damaged" in failure]
    if unread:
        notes.append(f"Notes of failures that cannot be read: {len(unread)} ({', '.join(unread[:3])}); delete them")
    if stored.others:
        notes.append(f"Trials of other settings, or of another version, that are not used: {stored.others}")
    if stored.damaged:
        names = ", ".join(path.name for path in stored.damaged[:3])
        notes.append(f"Files that hold no trial: {len(stored.damaged)} ({names}); delete them and run again")
    return notes


def _save(chapter: Chapter, folder: Path) -> dict[str, str]:
    """Write the figures as PNG files; returns each as a data URI."""
    uris = {}
    for stem, figure in chapter.figures.items():
        image, uris[stem] = drawn(figure)
        folder.mkdir(parents=True, exist_ok=True)
        _write(folder / f"{chapter.entry.id}-{stem}.png", image)
    return uris


def _facts(chapter: Chapter) -> dict[str, Any]:
    return {
        "id": chapter.entry.id,
        "title": chapter.entry.title,
        "source": chapter.entry.source,
        "says": chapter.entry.says,
        "verdict": str(chapter.verdict) if chapter.findings else None,
        "findings": [finding_row(finding) for finding in chapter.findings],
        "commands": list(chapter.commands),
        "settings": {
            name: {"config": chapter.configs[name], "n": len(seeds), "seeds": _seeds_in_words(seeds)}
            for name, seeds in chapter.seeds.items()
        },
        "versions": [dict(versions) for versions in chapter.versions],
        "notes": [*chapter.notes, *chapter.trouble],
        "figures": [f"figures/{chapter.entry.id}-{stem}.png" for stem in chapter.figures],
    }


def finding_row(finding: Comparison) -> dict[str, Any]:
    ours = finding.ours
    return {
        "what": finding.what,
        "dissertation": finding.dissertation,
        "here": "" if ours is None else str(ours),
        "value": None if ours is None else float(ours.mean),
        "low": None if ours is None else float(ours.low),
        "high": None if ours is None else float(ours.high),
        "sd": None if ours is None else float(ours.sd),
        "n": None if ours is None else int(ours.n),
        "verdict": str(finding.verdict),
        "note": finding.note,
    }


def _csv(chapters: Sequence[Chapter]) -> str:
    columns = (
        "claim",
        "title",
        "source",
        "what",
        "dissertation",
        "value",
        "low",
        "high",
        "sd",
        "n",
        "verdict",
        "note",
        "here",
    )
    text = io.StringIO()
    writer = csv.DictWriter(text, columns, lineterminator="\n")
    writer.writeheader()
    for chapter in chapters:
        about = {"claim": chapter.entry.id, "title": chapter.entry.title, "source": chapter.entry.source}
        writer.writerows({**about, **finding_row(finding)} for finding in chapter.findings)
    return text.getvalue()


def _markdown(chapters: Sequence[Chapter]) -> str:
    """A heading and a table for every claim with findings."""
    parts = [
        f"## {_plain_in_markdown(f'{chapter.entry.id}: {chapter.entry.title}')}\n\n"
        f"{table_of(_facts(chapter)['findings'])}"
        for chapter in chapters
        if chapter.findings
    ]
    return "\n".join(parts)


def table_of(findings: Sequence[Mapping[str, Any]]) -> str:
    """Findings, as claims.json has them, as a table in Markdown."""
    lines = ["| what | dissertation | here, 95% interval | n | verdict |", "|---|---|---|---|---|"]
    for finding in findings:
        n = "" if finding["n"] is None else str(finding["n"])
        verdict = f"{finding['verdict']}: {finding['note']}" if finding["note"] else finding["verdict"]
        columns = (finding["what"], finding["dissertation"], finding["here"], n, verdict)
        lines.append(f"| {' | '.join(map(_plain_in_markdown, columns))} |")
    return "\n".join(lines) + "\n"


def _plain_in_markdown(text: str) -> str:
    """``text`` on one line, with everything escaped that Markdown reads as a column, code, a link or HTML."""
    marks = str.maketrans({"\\": "\\\\", "|": "\\|", "`": "\\`", "&": "&amp;", "<": "&lt;"})
    return " ".join(text.split()).translate(marks).replace("](", "]\\(")


def _page(chapters: Sequence[Chapter], images: Mapping[str, Mapping[str, str]], folder: Path) -> str:
    films = {
        chapter.entry.id: data_uri("video/mp4", chapter.film.read_bytes())
        for chapter in chapters
        if chapter.film is not None
    }
    return page(
        "jointattn_mj.sweeps",
        "report.html",
        {"chapters": chapters, "images": images, "films": films, "folder": shlex.quote(str(folder))},
        seeds=_seeds_in_words,
        yaml=lambda config: yaml.safe_dump(config, sort_keys=False, default_flow_style=None),
    )


def _seeds_in_words(seeds: Sequence[int]) -> str:
    """``0-19, 30``."""
    parts = _ranges(seeds)
    return ", ".join(str(part[0]) if len(part) == 1 else f"{part[0]}-{part[-1]}" for part in parts) or "none"


def _write(path: Path, content: bytes) -> None:
    write_whole(path, lambda temporary: temporary.write_bytes(content))
