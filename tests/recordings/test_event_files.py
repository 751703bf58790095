"""Files of coding programs and tables of events: the same coding from each, and refusals that say what to do."""

import numpy as np
import pyarrow as pa
import pytest
from coded_files import FILES, GAZE, RATE, arrow, as_parquet, content, datavyu_archive, elan_document, plain, workbook
from shell import refused

from jointattn_mj import read_recordings, recordings
from jointattn_mj.errors import ConfigError, SeriesError
from jointattn_mj.recordings.groups import read_groups

CODES = {"infant": "b" * 8 + "f" * 12 + "b" * 6 + "d" * 24, "mother": "f" * 10 + "b" * 22 + "f" * 18}
"""First letters of the codes at the middles of steps of 0.1 s."""


@pytest.fixture
def write(tmp_path):
    def write(content: str | bytes, name: str = "x.csv"):
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


def letters(steps, tier, part=0):
    return "".join(steps.labels[tier][code][0] for code in steps.columns[tier][part])


def rows(events):
    columns = ("recording", "tier", "code", "onset", "offset")
    return list(zip(*(events.table[name].tolist() for name in columns), strict=True))


@pytest.mark.parametrize("kind", FILES)
def test_each_kind_of_file_has_the_same_events(write, kind):
    path = write(content(kind), FILES[kind][0])
    coding = recordings.read(path, rate=RATE)
    events = coding.events
    assert events.tier_names == ("infant", "mother")
    found = [(tier, code, round(onset, 6), round(offset, 6)) for _, tier, code, onset, offset in rows(events)]
    assert found == GAZE
    steps = coding.steps(0.1)
    assert {tier: letters(steps, tier) for tier in steps.columns} == CODES
    assert steps.notes() == ()


@pytest.mark.parametrize("kind", ["elan", "interact", "decimal commas"])
def test_measure_takes_event_files(jointattn, write, kind):
    path = write(content(kind), FILES[kind][0])
    options = ("--source", "mother", "--target", "infant", "--surrogates", 19, "--resamples", 0)
    refused(jointattn("measure", path, *options, "--rate", RATE), 2, "--step 0.1")
    outcome = jointattn("measure", path, *options, "--step", 0.1, "--rate", RATE)
    assert outcome.code == 0, outcome.err
    assert outcome.out.startswith("mother -> infant: 49 steps in 1 recording")
    refused(jointattn("measure", path, *options[:3], "infan", "--step", 0.1, "--rate", RATE), 2, "'infan'", "'infant'")


class TestElan:
    def test_times_that_follow_from_others(self, write):
        """Parts of an annotation, some without times; symbols in a row; a note on an annotation; an empty tier."""
        slots = "".join(
            f'<TIME_SLOT TIME_SLOT_ID="ts{i}"{f" TIME_VALUE={chr(34)}{ms}{chr(34)}" if ms is not None else ""}/>'
            for i, ms in enumerate((0, None, None, 900, 900, 1500), 1)
        )

        def aligned(name, first, last, value):
            return (
                f'<ANNOTATION><ALIGNABLE_ANNOTATION ANNOTATION_ID="{name}" TIME_SLOT_REF1="ts{first}" '
                f'TIME_SLOT_REF2="ts{last}"><ANNOTATION_VALUE>{value}</ANNOTATION_VALUE></ALIGNABLE_ANNOTATION></ANNOTATION>'
            )

        def dependent(name, parent, value, previous=""):
            return (
                f'<ANNOTATION><REF_ANNOTATION ANNOTATION_ID="{name}" ANNOTATION_REF="{parent}" {previous}>'
                f"<ANNOTATION_VALUE>{value}</ANNOTATION_VALUE></REF_ANNOTATION></ANNOTATION>"
            )

        tiers = {
            "reach": aligned("a1", 1, 4, "reach") + aligned("a2", 5, 6, "hold"),
            "parts": aligned("a3", 1, 2, "lift") + aligned("a4", 2, 3, "carry") + aligned("a5", 3, 4, "put"),
            "hand": dependent("a6", "a4", "left"),
            "signs": dependent("a7", "a2", "x") + dependent("a8", "a2", "y", 'PREVIOUS_ANNOTATION="a7"'),
            "smile": "",
        }
        parents = {"parts": "reach", "hand": "parts", "signs": "reach"}
        text = "".join(
            f'<TIER LINGUISTIC_TYPE_REF="plain" TIER_ID="{name}"'
            + (f' PARENT_REF="{parents[name]}"' if name in parents else "")
            + f">{inside}</TIER>"
            for name, inside in tiers.items()
        )
        events = recordings.read(write(elan_document(slots, text), "x.eaf")).events
        assert events.tier_names == tuple(tiers)
        assert [row[1:] for row in rows(events)] == [
            ("reach", "reach", 0, 0.9),
            ("reach", "hold", 0.9, 1.5),
            ("parts", "lift", 0, 0.3),
            ("parts", "carry", 0.3, 0.6),
            ("parts", "put", 0.6, 0.9),
            ("hand", "left", 0.3, 0.6),
            ("signs", "x", 0.9, 1.2),
            ("signs", "y", 1.2, 1.5),
        ]
        assert events.steps(0.5, "smile").labels == {"smile": ("(none)",)}

    @pytest.mark.parametrize(
        ("old", "new", "words"),
        [
            ("</TIER>", "", "no ELAN file that can be read"),
            ('ANNOTATION_ID="a3"', 'ANNOTATION_ID="a1"', "same name"),
            ('TIER_ID="mother"', 'TIER_ID="infant"', "same name"),
            ('TIME_VALUE="800"', "", "has no end|has no time"),
            ('TIME_VALUE="800"', 'TIME_VALUE="x"', "no ELAN file"),
            ('TIME_SLOT_ID="ts2" TIME_VALUE="800"', 'TIME_SLOT_ID="ts2" TIME_VALUE="-800"', "before it begins"),
        ],
    )
    def test_damaged(self, write, old, new, words):
        text = content("elan").decode()
        assert old in text
        with pytest.raises(SeriesError, match=words):
            recordings.read(write(text.replace(old, new), "x.eaf")).steps(0.1)

    def test_no_rows(self, write):
        with pytest.raises(SeriesError, match="no rows that could be steps"):
            read_recordings(write(content("elan"), "x.eaf"), "infant", rows_are_steps=True)
        with pytest.raises(SeriesError, match=r"`format='boris'` does not fit it"):
            _ = recordings.read(write(content("elan"), "x.eaf"), format="boris").events
        with pytest.raises(SeriesError, match="no column 'dyad'"):
            read_recordings(write(content("elan"), "x.eaf"), "infant", recording="dyad", step=0.1)


class TestBoris:
    HEADER = "Observation id,Subject,Behavior,Behavioral category,Modifier #1,Behavior type,Time\n"

    def test_categories_modifiers_and_points(self, write):
        path = write(
            self.HEADER + "d1,infant,look,gaze,ball,START,0\nd1,infant,wave,hand,,POINT,0.25\n"
            "d1,infant,look,gaze,ball,STOP,0.5\nd2,infant,look,gaze,face,START,0\nd2,infant,look,gaze,face,STOP,0.5\n"
        )
        assert rows(recordings.read(path).events) == [
            ("d1", "infant.gaze", "look|ball", 0, 0.5),
            ("d1", "infant.hand", "wave", 0.25, 0.25),
            ("d2", "infant.gaze", "look|face", 0, 0.5),
        ]
        other = recordings.read(path, tier_columns=["Subject", "Behavior"], code_columns=["Modifier #1"]).events
        assert other.tier_names == ("infant.look", "infant.wave")
        with pytest.raises(SeriesError, match=r"'d2' has no tier 'infant.hand'.*absent='nothing'.*absent='leave_out'"):
            recordings.read(path).steps(0.1)
        assert len(recordings.read(path, absent="nothing").steps(0.1).names) == 2
        left = recordings.read(path, absent="leave_out").steps(0.1)
        assert left.names == ("d1",)
        assert left.notes() == ("1 recording (d2) is left out, for want of a tier",)

    def test_a_point_event_without_an_end(self, write):
        header = "Subject,Behavior,Behavioral category,Behavior type,Start (s),Stop (s),Duration (s)\n"
        path = write(header + "infant,look,,STATE,0.0,1.5,1.5\ninfant,nod,,POINT,1.5,NA,NA\n")
        assert rows(recordings.read(path).events)[1] == ("x", "infant", "nod", 1.5, 1.5)
        with pytest.raises(SeriesError, match="does not say when 'look' ends in data row 1"):
            _ = recordings.read(write(header + "infant,look,,STATE,0.5,NA,NA\n")).events

    @pytest.mark.parametrize(
        ("lines", "words"),
        [
            ("d,i,look,,,START,0\n", "does not say when 'look' on 'i' of 'd' stops that starts in data row 1"),
            ("d,i,look,,,STOP,1\n", "stops 'look' on 'i' in data row 1, and never starts it"),
            ("d,i,look,,,START,0\nd,i,look,,,START,1\n", "starts 'look' twice, in data rows 1 and 2"),
            ("d,i,look,,,HALT,0\n", "kind 'halt' in data row 1; expected start, stop or point"),
            ("d,i,look,,,START,1\nd,i,look,,,STOP,0\n", "ends at 0 s, before it begins at 1 s"),
            ("d,i,look,,,START,soon\n", "holds 'soon', which is no time"),
            ("d,i,look,,,START,\n", "no onset for 'look' in data row 1"),
        ],
    )
    def test_what_does_not_fit_together(self, write, lines, words):
        with pytest.raises(SeriesError, match=words):
            recordings.read(write(self.HEADER + lines)).steps(0.1)

    def test_an_older_version(self, write):
        """Lines above the header, and the kind of a row is its status."""
        path = write(
            "Observation id\tx\n\nMedia file(s)\n\nPlayer #1\tx.mp4\n\n"
            "Time\tMedia file path\tTotal length\tFPS\tSubject\tBehavior\tBehavioral category\tComment\tStatus\n"
            "0.0\tx\t9\t25\tinfant\tlook\t\t\tSTART\n0.6\tx\t9\t25\tinfant\tlook\t\t\tSTOP\n"
        )
        assert rows(recordings.read(path).events) == [("x", "infant", "look", 0, 0.6)]


def test_datavyu_cells_with_several_codes(write):
    text = (
        "#4\nlook (MATRIX,true,)-who|NOMINAL,where|NOMINAL\n00:00:00:000,00:00:01:000,(i,a\\,b)\n"
        "00:00:01:000,00:00:02:000,(m,)\nnote (TEXT,true,)\n00:00:00:000,00:00:00:000,two\n"
    )
    assert [row[1:] for row in rows(recordings.read(write(text)).events)] == [
        ("look.who", "i", 0, 1),
        ("look.who", "m", 1, 2),
        ("look.where", "a,b", 0, 1),
        ("note", "two", 0, 0),
    ]
    with pytest.raises(SeriesError, match="a cell with 1 codes in line 3; expected 2"):
        _ = recordings.read(write(text.replace("(i,a\\,b)", "(i)"))).events
    with pytest.raises(SeriesError, match="neither a column nor a cell in line 4"):
        _ = recordings.read(write(text.replace("00:00:01:000,00:00:02:000", "00:00:01:00,x"))).events


def test_interact_by_levels(write):
    path = write(
        "Level\tstart time\tOffset\tMemo\tgaze\n1\t\t\tday\t\n2\t\t\tset\t\n3\t0:00:00.0\t0:00:01.0\t\tball\n"
        "2\t\t\tset\t\n3\t0:00:00.0\t0:00:02.0\t\tface\n"
    )
    assert rows(recordings.read(path).events) == [("x 1.1", "gaze", "ball", 0, 1), ("x 1.2", "gaze", "face", 0, 2)]


class TestTimes:
    @pytest.mark.parametrize(
        ("header", "first", "last", "options"),
        [
            ("onset,offset", "1.5", "2", {}),
            ("onset,offset", "1", "2.5", {}),
            ("onset_ms,offset_ms", "1500", "2000", {}),
            ("onset (s),offset (s)", "1", "2", {}),
            ("onset,offset", "1500", "2000", {"time_unit": "ms"}),
            ("onset,offset", "45", "60", {"time_unit": "frames", "rate": 30}),
            ("start frame,end frame", "45", "60", {"rate": 29.97}),
            ("Begin,End", "00:00:01.5", "00:00:02", {}),
            ("Begin,End", "00:01.500", "00:02", {}),
            ("Begin,End", "00:00:01:500", "00:00:02:000", {}),
            ("Begin,End", "00:00:01:15", "00:00:02:00", {"rate": 30}),
            ("start,duration", "1.5", "0.5", {}),
            ("Start Time,Duration", "0:01.5", "0.5", {}),
        ],
    )
    def test_ways_to_write_them(self, write, header, first, last, options):
        path = write(f"tier,{header},code\na,{first},{last},x\n")
        ((_, _, _, onset, offset),) = rows(recordings.read(path, **options).events)
        if "1" in header or "." not in first:
            assert onset < offset
        meant = {"45": 45 / options.get("rate", 1), "1": 1.0}.get(first, 1.5)
        assert onset == pytest.approx(meant)
        assert offset == pytest.approx({"60": 60 / options.get("rate", 1), "2.5": 2.5}.get(last, 2.0))

    @pytest.mark.parametrize(
        ("first", "last", "options", "words"),
        [
            ("1", "2", {}, "whole numbers without a unit, such as 1; say `time_unit='s'`"),
            ("00:00:01:12", "00:00:02:00", {}, "ends in frames.*`rate=25`"),
            ("00:00:01:30", "00:00:02:00", {"rate": 25}, "frames a second they go to 24"),
            ("1", "2", {"time_unit": "frames"}, "`rate=25`"),
            ("00:71:00", "00:72:00", {}, "minutes and seconds go to 59"),
            ("1e99", "2", {"time_unit": "s"}, "must lie within"),
            ("x", "2.5", {}, "'x', which is no time"),
            ("1.5", "", {}, "does not say when 'x' ends in data row 1; a point event"),
            ("2.5", "1.5", {}, "ends at 1.5 s, before it begins at 2.5 s"),
        ],
    )
    def test_what_cannot_be_read(self, write, first, last, options, words):
        with pytest.raises(SeriesError, match=words):
            _ = recordings.read(write(f"tier,onset,offset,code\na,{first},{last},x\n"), **options).events


class TestTables:
    def test_names_that_look_like_numbers(self, write):
        """Codes, tiers and recordings; the same from each kind of file."""
        header = ("recording", "tier", "onset", "offset", "code")
        body = [("2E1", "12.1", 0, 0.5, "4e5000"), ("2E1", "12.1", 0.5, 1, "12.10"), ("20", "12.1", 0, 1, "007")]
        table = pa.table({name: [str(row[i]) for row in body] for i, name in enumerate(header)})
        text = "\n".join(",".join(map(str, row)) for row in (header, *body)) + "\n"
        for made in (text, as_parquet(table), workbook([header, *body])):
            events = recordings.read(write(made)).events
            assert events.recordings == ("2E1", "20")
            assert events.tier_names == ("12.1",)
            assert set(events.table["code"]) == {"4e5000", "12.10", "007"}

    def test_whole_numbers_are_the_same_however_written(self, write):
        """A spreadsheet has no 1.0."""
        header = ("tier", "onset", "offset", "code")
        body = [("a", 0.0, 0.5, 1.0), ("a", 0.5, 1.0, 2.0)]
        table = pa.table({name: [row[i] for row in body] for i, name in enumerate(header)})
        text = "\n".join(",".join(map(str, row)) for row in (header, *body)) + "\n"
        for made in (text, text.replace(",1.0\n", ",1\n"), as_parquet(table), workbook([header, *body])):
            steps = recordings.read(write(made)).steps(0.25)
            assert (steps.labels["a"], steps.columns["a"][0].tolist()) == (("1", "2"), [0, 0, 1, 1])

    @pytest.mark.parametrize(
        ("name", "words"),
        [("NA", ""), (" NA", ""), (".", "."), ("-99", "-99"), ("-99.0", "-99"), ("uncodable", "uncodable")],
    )
    def test_missing_codes(self, write, name, words):
        path = write(f"tier,onset,offset,code\na,0,0.5,x\na,0.5,1,{name}\na,1,1.5,x\na,1.5,2,y\n")
        coding = recordings.read(path, missing_values=[words, "-"])
        with pytest.raises(SeriesError, match=r"missing codes in 5 steps, the first at 0.5 s.*missing='break'"):
            coding.steps(0.1)
        steps = coding.steps(0.1, missing="break")
        assert [len(part) for part in steps.columns["a"]] == [5, 10]
        assert steps.groups == [0, 0]
        assert "5 of 20 steps have missing values; recordings were cut there" in steps.notes()

    def test_rows_without_a_tier_or_a_recording(self, write):
        """Cells left blank below the first of a group, as people fill in tables: nothing moves in silence."""
        header, rows = "dyad,tier,onset,offset,code\n", "d1,a,0,0.5,x\nd1,a,0.5,1,y\n{},,1,1.5,x\n"
        path = write(header + rows.format("d1"))
        events = recordings.read(path).events
        assert events.tier_names == ("a", "events")
        assert events.remarks == (f"1 row of {path} without a tier, on the tier 'events'",)
        with pytest.raises(SeriesError, match=r"'dyad' of .* names no recording in 1 row, the first in data row 3"):
            _ = recordings.read(write(header + rows.format(""))).events

    def test_columns_without_a_header(self, write):
        path = write("ann,x,0,500\nann,y,500,1000\n")
        events = recordings.read(path, columns=["tier", "code", "onset", "offset"], time_unit="ms").events
        assert rows(events) == [("x", "ann", "x", 0, 0.5), ("x", "ann", "y", 0.5, 1)]
        with pytest.raises(SeriesError, match="4 columns, and `columns` names 3"):
            _ = recordings.read(path, columns=["code", "onset", "offset"]).events
        with pytest.raises(SeriesError, match=r"no columns that say when events begin and end.*`columns`"):
            _ = recordings.read(write("a,b\n1,2\n1,2\n"), step=0.1).events

    def test_columns_without_a_header_that_are_not_clear(self, write):
        """A first column that counts the rows is no onset."""
        path = write("0,a,0.5,1.0,x\n1,a,1.0,2.0,y\n2,a,2.0,3.5,x\n")
        with pytest.raises(SeriesError, match="no columns that say when events begin"):
            recordings.read(path).steps(0.5)
        columns = ["-", "tier", "onset", "offset", "code"]
        assert recordings.read(path, columns=columns).events.table["offset"].tolist() == [1, 2, 3.5]

    def test_columns_of_tiers_and_codes(self, write):
        path = write("who2,begin,end,where,how\nann,0,1.5,toy,long\n,1.5,2,face,short\n")
        assert recordings.read(path).events.tier_names == ("who2", "where", "how")
        with pytest.raises(SeriesError, match=r"several columns that may be the code.*`code_columns`"):
            _ = recordings.read(path, tier_columns=["who2"]).events
        events = recordings.read(path, tier_columns=["who2"], code_columns=["where", "how"]).events
        assert [row[1:3] for row in rows(events)] == [("ann", "toy|long"), ("where how", "face|short")]

    def test_codes_of_tiers_side_by_side(self, write):
        path = write(content("datavyu side by side"))
        events = recordings.read(path, code_columns=["mother"]).events
        assert [row[1:] for row in rows(events)] == [row for row in GAZE if row[0] == "mother"]
        with pytest.raises(SeriesError, match="tiers side by side: leave `tier_columns` out"):
            _ = recordings.read(path, tier_columns=["mother"]).events

    def test_quotes_that_swallow_rows(self, write):
        """A quotation mark that is part of a label, as some programs write it."""
        path = write('tier\tonset\toffset\tcode\na\t0.0\t1.5\t"toy\na\t1.5\t2\tface\na\t2\t3\t"toy\n')
        with pytest.raises(SeriesError, match="quotation mark in column 'code' that swallows rows"):
            _ = recordings.read(path).events

    def test_several_sheets(self, write):
        header = ("recording", "tier", "onset", "offset", "code")
        first, second = [header, ("d1", "a", 0.0, 1.5, "x")], [header, ("d2", "a", 0.0, 1.5, "y")]
        assert recordings.read(write(workbook(first, second))).events.recordings == ("d1", "d2")
        path = write(workbook(first, [("what", "else")]))
        with pytest.raises(SeriesError, match=r"several sheets.*`sheet='Sheet1'`"):
            _ = recordings.read(path).events
        assert recordings.read(path, sheet="Sheet1").events.recordings == ("d1",)
        with pytest.raises(SeriesError, match="no sheet 'x'; there are Sheet1, Sheet2"):
            _ = recordings.read(path, sheet="x").events

    def test_steps_are_no_events(self, write):
        path = write("a,b\nx,1\ny,0\nx,1\n")
        with pytest.raises(SeriesError, match="a row for every step, and no events"):
            _ = recordings.read(path).events
        with pytest.raises(SeriesError, match="no columns that say when events begin"):
            read_recordings(path, ["a"], step=0.1)
        assert recordings.read(path).steps().columns["b"][0].tolist() == [1, 0, 1]


class TestFolders:
    def test_a_file_a_recording(self, write, tmp_path):
        write(content("elan"), "all/ann.eaf")
        write(content("boris aggregated").replace(b"x,2026", b"bob,2026"), "all/b.csv")
        write("", "all/film.mp4")
        write("", "all/.hidden.csv")
        write("", "all/~$b.xlsx")
        steps = read_recordings(tmp_path / "all", ["mother", "infant"], step=0.1)
        assert steps.names == ("ann", "bob")
        assert (steps.groups, steps.transitions) == ([0, 1], 98)
        assert [letters(steps, "infant", part) for part in (0, 1)] == [CODES["infant"]] * 2
        assert "1 file of" in steps.notes()[0] and "film.mp4" in steps.notes()[0]

    def test_tables_of_steps(self, write, tmp_path):
        for name in ("ann", "bob"):
            write(f"a,who\n{name},1\ny,1\n{name},1\ny,2\nz,2\n", f"all/{name}.csv")
        steps = read_recordings(tmp_path / "all", "a")
        assert steps.labels == {"a": ("ann", "bob", "y", "z")}
        assert [part.tolist() for part in steps.columns["a"]] == [[0, 2, 0, 2, 3], [1, 2, 1, 2, 3]]
        assert steps.names == ("ann", "bob")
        with pytest.raises(SeriesError, match="recording '1' stands in several files"):
            read_recordings(tmp_path / "all", "a", recording="who")

    def test_people_in_files_of_their_own(self, write, tmp_path):
        """Tiers of one recording in several files come together; the same tier twice does not."""
        for tier in ("infant", "mother"):
            lines = [line for line in plain().splitlines() if line.startswith((tier, "tier"))]
            body = "".join(f"{'dyad' if i == 0 else '7'},{line}\n" for i, line in enumerate(lines))
            write(body, f"all/{tier}.csv")
        steps = read_recordings(tmp_path / "all", ["infant", "mother"], recording="dyad", step=0.1)
        assert {tier: letters(steps, tier) for tier in steps.columns} == CODES
        write(body, "all/again.csv")
        with pytest.raises(SeriesError, match="several files have the tier 'mother' of recording '7'"):
            read_recordings(tmp_path / "all", "mother", recording="dyad", step=0.1)

    def test_none(self, tmp_path):
        with pytest.raises(SeriesError, match="no file that ends in"):
            read_recordings(tmp_path, "a")

    def test_a_recording_ends_where_another_begins(self, write):
        path = write("dyad,tier,onset,offset,code\n1.1,a,0,1,x\n1.2,a,0,1.5,y\n1.10,a,0,1,x\n")
        steps = read_recordings(path, "a", recording="dyad", step=0.5)
        assert steps.names == ("1.1", "1.2", "1.10")
        assert [len(part) for part in steps.columns["a"]] == [2, 3, 2]


class TestFromPython:
    def test_tables_of_pandas_and_back(self):
        pandas = pytest.importorskip("pandas")
        frame = arrow().to_pandas()
        coding = recordings.read(frame)
        assert recordings.read(frame.set_index("tier")).events.table == coding.events.table
        back = coding.events.to_pandas()
        assert isinstance(back, pandas.DataFrame)
        assert back[["tier", "code", "onset", "offset"]].to_numpy().tolist() == [list(row) for row in GAZE]
        assert recordings.read(back).events.table == coding.events.table
        times = frame.assign(onset=pandas.to_timedelta(frame.onset, "s"), offset=pandas.to_timedelta(frame.offset, "s"))
        assert np.allclose(recordings.read(times).events.table["offset"], coding.events.table["offset"])
        steps = recordings.read(pandas.DataFrame({"a": ["x", "y", "x"], "b": [1.0, 2.0, 1.0]})).steps()
        assert steps.labels == {"a": ("x", "y"), "b": ("1", "2")}
        assert steps.to_pandas().to_numpy().tolist() == [["table", 0, *row] for row in ("x1", "y2", "x1")]

    def test_measures_as_methods(self):
        coding = recordings.read(arrow())
        result = coding.measure("mother", "infant", step=0.1, surrogates=19, resamples=0)
        assert result.title.startswith("mother -> infant: 49 steps")
        found = coding.discover("mother", "infant", "infant", step=0.1, surrogates=19, resamples=0)
        assert len(found.findings) == 1

    def test_what_is_no_source(self):
        with pytest.raises(SeriesError, match="expected a path, or a table"):
            recordings.read(3).steps()
        with pytest.raises(ConfigError, match="no option 'recordin'"):
            recordings.read("x.csv", recordin="a")
        assert repr(recordings.read("x.csv")) == "Coding('x.csv')"


def test_archives_that_are_something_else(write):
    archive = bytearray(datavyu_archive())
    archive[40:60] = bytes(20)
    for made in (bytes(archive), workbook([]), b"PK\x03\x04"):
        with pytest.raises(SeriesError):
            _ = recordings.read(write(bytes(made))).events


def test_columns_about_recordings_are_no_codes(write):
    """Ages beside the codes, and times with all digits that a floating-point number has."""
    lines = "".join(
        f"{dyad},{age},{who},{i / 3 + 0.1 * 3},{1 / 3},{look}\n"
        for dyad, age in (("a", 6), ("b", 9))
        for who, looks in (("mother", "xyx"), ("infant", "xxy"))
        for i, look in enumerate(looks)
    )
    assert "0.30000000000000004" in lines
    path = write(f"dyad,age,who,start,duration,look\n{lines}")
    coding = recordings.read(path, step=0.1)
    assert coding.about("age") == {"a": "6", "b": "9"}
    assert coding.events.tier_names == ("mother.age", "infant.age", "mother.look", "infant.look")
    measured = coding.measure("mother", "infant", step=0.1, by="age", surrogates=19, resamples=0)
    assert [group.name for group in measured.dyads[0].groups] == ["all", "age 6", "age 9"]
    changed = write(path.read_text().replace("a,6,mother", "a,7,mother", 1))
    with pytest.raises(SeriesError, match="'age' changes within recording 'a': 6, 7"):
        recordings.read(changed).about("age")
    of_a = "".join(line[2:] for line in lines.splitlines(keepends=True) if line[0] == "a")
    alone = write(f"age,who,start,duration,look\n{of_a}")
    assert recordings.read(alone).about("age") == {alone.stem: "6"}  # named by its file


def test_groups_of_recordings_from_tiers_and_tables(write):
    looks = recordings.Events.of(["gaze", "age"] * 2, ["x", "6", "y", "9"], [0] * 4, [1.5] * 4, list("aabb"))
    coding = recordings.read(looks.to_pandas())
    assert coding.about("age") == {"a": "6", "b": "9"}
    with pytest.raises(SeriesError, match=r"no column or tier 'agee'.*'age'.*`groups`"):
        coding.about("agee")
    assert read_groups(write("recording;age\na.eaf; 6\nb;9\n"), "age") == {"a.eaf": "6", "a": "6", "b": "9"}
    with pytest.raises(SeriesError, match="two values of 'age' for 'a': 6 and 9"):
        read_groups(write("who,age\na,6\na,9\n"), "age")
    with pytest.raises(SeriesError, match="no column 'sex'"):
        read_groups(write("who,age\na,6\n"), "sex")
