"""A claim from Python, on experiments of toys: trials are stored once, and a result is what its folder holds."""

from pathlib import Path

import pytest
from toys.registry import REGISTRY

from jointattn_mj import ClaimResult, Table, run_claim
from jointattn_mj.errors import ConfigError, OutputError, SweepError
from jointattn_mj.sweeps.claim import Comparison, Verdict
from jointattn_mj.sweeps.run import SweepWatcher, Tally

pytestmark = pytest.mark.integration


class Counts(SweepWatcher):
    """Remembers the last tally."""

    def end(self, tally: Tally) -> None:
        self.tally = tally


def coins(out: Path, **options) -> ClaimResult:
    return run_claim("1.1", out, jobs=1, registry="toys.registry", **options)


@pytest.fixture(scope="module")
def result(tmp_path_factory) -> ClaimResult:
    return coins(tmp_path_factory.mktemp("claims") / "out", runs=6)


def test_a_result_is_what_its_folder_holds(result):
    assert ClaimResult.open(result.folder, "1.1", REGISTRY) == result
    assert ClaimResult.open(str(result.folder), "1.1", REGISTRY).findings == result.findings
    assert result != "result"


def test_types_of_attributes(result):
    assert (result.entry.id, result.entry.title) == ("1.1", "Coins & <luck>")
    assert result.verdict is Verdict.PARTLY
    assert [type(finding) for finding in result.findings] == [Comparison] * 3
    assert result.runs == {"fair": 6, "loaded": 6}
    assert result.report.exists() and all(path.exists() for path in result.figures.values())
    assert list(result.figures) == ["heads"] and result.notes == ()
    table = result.table()
    assert isinstance(table, Table) and len(table) == 3
    assert table["n"].tolist()[:2] == [6, 6] and table["verdict"][2] == "extension"


def test_a_repr_is_a_short_table(result):
    lines = repr(result).splitlines()
    assert len(lines) == 2 + len(result.findings) and max(map(len, lines)) <= 200
    assert lines[0].startswith("ClaimResult 1.1 (Coins & <luck>): partly, up to 6 runs, in ")
    assert lines[2].split() == ["heads", "of", "the", "fair", "one", "0.5", *lines[2].split()[6:-1], "reproduced"]


def test_only_what_is_missing_is_run(result):
    counts = Counts()
    assert coins(result.folder, runs=6, watcher=counts) == result
    assert (counts.tally.todo, counts.tally.stored) == (0, 12)


def test_some_of_it(tmp_path):
    some = coins(tmp_path / "out", runs=1, setting="fair", seed=3)
    assert some.runs == {"fair": 1, "loaded": 0} and some.verdict is Verdict.UNDECIDED


def test_trials_that_fail(tmp_path, monkeypatch):
    monkeypatch.setenv("TOY_TROUBLE", "error:1")
    with pytest.raises(SweepError, match=r"2 trials failed.* stands on its edge; alone: jointattn experiment run 1\.1"):
        coins(tmp_path / "out", runs=2)
    monkeypatch.delenv("TOY_TROUBLE")
    assert coins(tmp_path / "out", runs=2).runs == {"fair": 2, "loaded": 2}


def test_what_is_not_there(tmp_path):
    with pytest.raises(ConfigError, match=r"no claim has the id '9\.9'; there are 4\.4"):
        run_claim("9.9", tmp_path)
    with pytest.raises(ConfigError, match=r"no setting is called 'edge'"):
        coins(tmp_path, setting="edge")
    with pytest.raises(OutputError, match=r"holds no trials of claim 1\.1"):
        ClaimResult.open(tmp_path, "1.1", REGISTRY)
    with pytest.raises(ConfigError, match=r"there are 1\.1, 1\.2"):
        ClaimResult.open(tmp_path, "1.3", REGISTRY)
