"""One coded interaction as each coding program writes it, made from the descriptions of their formats."""

import io
import zipfile
from collections.abc import Callable, Sequence
from xml.sax.saxutils import escape

import pyarrow as pa
from pyarrow import parquet

Row = tuple[str, str, float, float]

GAZE: list[Row] = [
    ("infant", "ball", 0.0, 0.8),
    ("infant", "face", 0.8, 2.04),
    ("infant", "ball", 2.04, 2.6),
    ("infant", "door", 2.6, 5.0),
    ("mother", "face", 0.0, 1.0),
    ("mother", "ball", 1.0, 3.2),
    ("mother", "face", 3.2, 5.0),
]
"""Tier, code, onset and offset in seconds; all are frames at 25 a second."""
RATE = 25


def _lines(header: str, rows: Sequence[Sequence[object]], mark: str = "\t") -> str:
    return "".join(f"{line}\n" for line in [header, *(mark.join(map(str, row)) for row in rows)])


def _ms(seconds: float) -> int:
    return round(seconds * 1000)


def _clock(seconds: float) -> str:
    return f"00:{int(seconds) // 60:02d}:{int(seconds) % 60:02d}.{_ms(seconds) % 1000:03d}"


def _with_frames(seconds: float) -> str:
    return f"00:00:{int(seconds):02d}:{round(seconds % 1 * RATE):02d}"


def _with_thousandths(seconds: float) -> str:
    return _clock(seconds).replace(".", ":")


def elan() -> bytes:
    """An annotation file: a tier each, with time slots of their own, and an empty tier."""
    slots, tiers = [], []
    for tier in ("infant", "mother"):
        annotations = []
        for row in GAZE:
            if row[0] == tier:
                first = len(slots) + 1
                slots += row[2:]
                annotations.append(
                    f'<ANNOTATION><ALIGNABLE_ANNOTATION ANNOTATION_ID="a{first}" TIME_SLOT_REF1="ts{first}" '
                    f'TIME_SLOT_REF2="ts{first + 1}"><ANNOTATION_VALUE>{escape(row[1])}</ANNOTATION_VALUE>'
                    "</ALIGNABLE_ANNOTATION></ANNOTATION>"
                )
        tiers.append(f'<TIER LINGUISTIC_TYPE_REF="plain" TIER_ID="{tier}">{"".join(annotations)}</TIER>')
    times = "".join(f'<TIME_SLOT TIME_SLOT_ID="ts{i}" TIME_VALUE="{_ms(slot)}"/>' for i, slot in enumerate(slots, 1))
    return elan_document(times, "\n".join(tiers))


def elan_document(slots: str, tiers: str) -> bytes:
    """The document around time slots and tiers."""
    return (
        '<?xml version="1.0" encoding="UTF-8"?>\n<ANNOTATION_DOCUMENT AUTHOR="" DATE="2026-01-01T00:00:00+00:00" '
        'FORMAT="3.0" VERSION="3.0" xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" '
        'xsi:noNamespaceSchemaLocation="http://www.mpi.nl/tools/elan/EAFv3.0.xsd">\n'
        f'<HEADER MEDIA_FILE="" TIME_UNITS="milliseconds"/>\n<TIME_ORDER>{slots}</TIME_ORDER>\n{tiers}\n'
        '<LINGUISTIC_TYPE GRAPHIC_REFERENCES="false" LINGUISTIC_TYPE_ID="plain" TIME_ALIGNABLE="true"/>\n'
        "</ANNOTATION_DOCUMENT>\n"
    ).encode()


def elan_text() -> str:
    """Tab-delimited text with a header, all formats of time."""
    header = "\t".join(
        f"{what} - {unit}"
        for what in ("Begin Time", "End Time", "Duration")
        for unit in ("hh:mm:ss.ms", "ss.msec", "msec")
    )
    rows = [
        (t, "", *(f(x) for x in (a, b, b - a) for f in (_clock, lambda x: round(x, 3), _ms)), c) for t, c, a, b in GAZE
    ]
    return _lines(f"Tier\tParticipant\t{header}\tAnnotation", rows)


def elan_text_without_header() -> str:
    """Tab-delimited text as ELAN writes it by default."""
    return "".join(f"{t}\t\t{_clock(a)}\t{_clock(b)}\t{_clock(b - a)}\t{c}\n" for t, c, a, b in GAZE)


def elan_text_of_several_files() -> str:
    """Tab-delimited text without a header, with participants, all formats of time and the names of the files."""
    return "".join(
        f"{t}\tparticipant of {t}\t"
        + "\t".join(str(f(x)) for x in (a, b, b - a) for f in (_clock, lambda x: f"{x:.3f}", _ms))
        + f"\t{c}\t/home/me/x.eaf\n"
        for t, c, a, b in GAZE
    )


def elan_text_side_by_side() -> str:
    """Tab-delimited text with a column for each tier."""
    rows = [(_ms(a), _ms(b), c if t == "infant" else "", c if t == "mother" else "") for t, c, a, b in GAZE]
    return _lines("Begin Time - msec\tEnd Time - msec\tinfant\tmother", rows)


BORIS_BEFORE = (
    "Observation id\tObservation date\tDescription\tObservation duration\tObservation type\tSource\tTime offset (s)"
)


def boris_tabular() -> str:
    """A row where a state starts, and one where it stops."""
    changes = sorted([(a, t, c, "START") for t, c, a, _ in GAZE] + [(b, t, c, "STOP") for t, c, _, b in GAZE])
    changes.sort(key=lambda row: (row[0], row[3] == "START"))
    rows = [
        ("x", "2026-01-01", "", 5, "Media", "x.mp4", 0, t, c, "", kind, at, "x.mp4", 1, "")
        for at, t, c, kind in changes
    ]
    after = "Subject\tBehavior\tBehavioral category\tBehavior type\tTime\tMedia file name\tImage index\tComment"
    return _lines(f"{BORIS_BEFORE}\t{after}", rows)


def boris_aggregated() -> str:
    """A row a state."""
    rows = [
        (
            "x",
            "2026-01-01",
            "",
            "Media",
            "x.mp4",
            0,
            5,
            5,
            25,
            t,
            5,
            c,
            "",
            "STATE",
            a,
            b,
            round(b - a, 3),
            "x.mp4",
            "",
            "",
        )
        for t, c, a, b in GAZE
    ]
    header = (
        "Observation id,Observation date,Description,Observation type,Source,Time offset (s),Coding duration,"
        "Media duration (s),FPS (frame/s),Subject,Observation duration by subject by observation,Behavior,"
        "Behavioral category,Behavior type,Start (s),Stop (s),Duration (s),Media file name,Comment start,Comment stop"
    )
    return _lines(header, rows, ",")


def datavyu_text() -> str:
    """The text of a spreadsheet, as in the archive and in the export by columns."""
    lines = ["#4"]
    for tier in ("infant", "mother"):
        lines.append(f"{tier} (MATRIX,true,)-code01|NOMINAL")
        lines += [f"{_with_thousandths(a)},{_with_thousandths(b)},({c})" for t, c, a, b in GAZE if t == tier]
    return "\n".join(lines) + "\n"


def datavyu_archive() -> bytes:
    """The archive, .opf."""
    archive = io.BytesIO()
    with zipfile.ZipFile(archive, "w") as file:
        file.writestr("project", "!project {version: 5}\n")
        file.writestr("db", datavyu_text())
    return archive.getvalue()


def datavyu_side_by_side() -> str:
    """The export of the spreadsheet side by side, in milliseconds."""
    blocks = [[(c, a, b) for t, c, a, b in GAZE if t == tier] for tier in ("infant", "mother")]
    rows = []
    for i in range(max(map(len, blocks))):
        row: list[object] = []
        for block in blocks:
            row += [i + 1, _ms(block[i][1]), _ms(block[i][2]), block[i][0]] if i < len(block) else [""] * 4
        rows.append(row)
    header = ",".join(f"{tier}{end}" for tier in ("infant", "mother") for end in (".ordinal", ".onset", ".offset", ""))
    return _lines(header, rows, ",")


def observer() -> bytes:
    """An event log in UTF-16, with decimal commas."""
    changes = [(a, b - a, t, c, "State start") for t, c, a, b in GAZE]
    changes += [(b, 0, t, c, "State stop") for t, c, _, b in GAZE]
    changes.sort(key=lambda row: (row[0], row[4] == "State start"))
    rows = [
        (
            f"01-01-2026 10:00:{at}",
            f"{at:.2f}".replace(".", ","),
            f"{length:.2f}".replace(".", ","),
            "x",
            "log",
            c,
            t,
            kind,
            "",
        )
        for at, length, t, c, kind in changes
    ]
    header = (
        "Date_Time_Absolute_dmy_hmsf\tTime_Relative_sf\tDuration_sf\tObservation\tEvent_Log\tBehavior\tSubject\t"
        "Event_Type\tComment"
    )
    return _lines(header, rows).encode("utf-16")


def interact() -> str:
    """An event list with a column for each class; its times end in frames."""
    rows = [
        (1, 1, i, _with_frames(a), _with_frames(b), "", c if t == "infant" else "", c if t == "mother" else "")
        for i, (t, c, a, b) in enumerate(GAZE, 1)
    ]
    return _lines("DataGroup\tDataSet\tEvent\tOnset\tOffset\tDuration\tinfant\tmother", rows)


def plain(mark: str = ",", decimal: str = ".") -> str:
    """A table of events, in seconds."""
    rows = [(t, *(f"{x:.2f}".replace(".", decimal) for x in (a, b)), c) for t, c, a, b in GAZE]
    return _lines(mark.join(("tier", "onset", "offset", "code")), rows, mark)


def with_durations() -> str:
    """A table of events with durations, in frames."""
    rows = [(t, round(a * RATE), round((b - a) * RATE), c) for t, c, a, b in GAZE]
    return _lines("who;start_frame;duration_frames;gaze", rows, ";")


def arrow() -> pa.Table:
    """The plain table in Arrow's columns."""
    tier, code, onset, offset = (list(column) for column in zip(*GAZE, strict=True))
    return pa.table({"tier": tier, "onset": onset, "offset": offset, "code": code})


def as_parquet(table: pa.Table) -> bytes:
    """A table as a Parquet file."""
    file = io.BytesIO()
    parquet.write_table(table, file)
    return file.getvalue()


def workbook(*sheets: Sequence[Sequence[object]]) -> bytes:
    """An Excel workbook (ECMA-376) with text in its cells, and numbers."""
    main = "http://schemas.openxmlformats.org/spreadsheetml/2006/main"
    office = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
    package = "http://schemas.openxmlformats.org/package/2006"

    kind = "application/vnd.openxmlformats-officedocument.spreadsheetml"
    links_kind = "application/vnd.openxmlformats-package.relationships+xml"

    def cell(value: object) -> str:
        if value is None:
            return "<c/>"
        if isinstance(value, bool):
            return f'<c t="b"><v>{int(value)}</v></c>'
        if isinstance(value, (int, float)):
            return f"<c><v>{value!r}</v></c>"
        return f'<c t="inlineStr"><is><t xml:space="preserve">{escape(str(value))}</t></is></c>'

    file = io.BytesIO()
    numbers = range(1, len(sheets) + 1)
    with zipfile.ZipFile(file, "w") as archive:
        parts = "".join(
            f'<Override PartName="/xl/worksheets/sheet{i}.xml" ContentType="{kind}.worksheet+xml"/>' for i in numbers
        )
        archive.writestr(
            "[Content_Types].xml",
            f'<Types xmlns="{package}/content-types"><Default Extension="rels" ContentType="{links_kind}"/>'
            f'<Override PartName="/xl/workbook.xml" ContentType="{kind}.sheet.main+xml"/>{parts}</Types>',
        )
        archive.writestr(
            "_rels/.rels",
            f'<Relationships xmlns="{package}/relationships"><Relationship Id="r1" Type="{office}/officeDocument" '
            'Target="xl/workbook.xml"/></Relationships>',
        )
        names = "".join(f'<sheet name="Sheet{i}" sheetId="{i}" r:id="r{i}"/>' for i in numbers)
        archive.writestr(
            "xl/workbook.xml", f'<workbook xmlns="{main}" xmlns:r="{office}"><sheets>{names}</sheets></workbook>'
        )
        links = "".join(
            f'<Relationship Id="r{i}" Type="{office}/worksheet" Target="worksheets/sheet{i}.xml"/>' for i in numbers
        )
        archive.writestr(
            "xl/_rels/workbook.xml.rels", f'<Relationships xmlns="{package}/relationships">{links}</Relationships>'
        )
        for i, rows in zip(numbers, sheets, strict=True):
            data = "".join(f"<row>{''.join(map(cell, row))}</row>" for row in rows)
            archive.writestr(
                f"xl/worksheets/sheet{i}.xml", f'<worksheet xmlns="{main}"><sheetData>{data}</sheetData></worksheet>'
            )
    return file.getvalue()


def plain_workbook() -> bytes:
    """The plain table in a workbook."""
    return workbook([("tier", "onset", "offset", "code"), *((t, a, b, c) for t, c, a, b in GAZE)])


FILES: dict[str, tuple[str, Callable[[], bytes | str]]] = {
    "elan": ("x.eaf", elan),
    "elan text": ("x.txt", elan_text),
    "elan text without a header": ("x.txt", elan_text_without_header),
    "elan text of several files": ("x.txt", elan_text_of_several_files),
    "elan text side by side": ("x.txt", elan_text_side_by_side),
    "boris tabular": ("x.tsv", boris_tabular),
    "boris aggregated": ("x.csv", boris_aggregated),
    "datavyu text": ("x.csv", datavyu_text),
    "datavyu archive": ("x.opf", datavyu_archive),
    "datavyu side by side": ("x.csv", datavyu_side_by_side),
    "observer": ("x.txt", observer),
    "interact": ("x.txt", interact),
    "commas": ("x.csv", plain),
    "decimal commas": ("x.csv", lambda: plain(";", ",")),
    "durations in frames": ("x.csv", with_durations),
    "parquet": ("x.parquet", lambda: as_parquet(arrow())),
    "excel": ("x.xlsx", plain_workbook),
}
"""By what it is: a file's name, and what makes it."""


def content(kind: str) -> bytes:
    """A file of one kind."""
    made = FILES[kind][1]()
    return made if isinstance(made, bytes) else made.encode()
