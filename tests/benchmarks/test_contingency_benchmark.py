"""The benchmark of contingency measures what it says; how fast is not for tests to judge."""

import json
import math
import sys

import numpy as np
import pytest

from jointattn_mj.benchmarks import contingency as benchmark
from jointattn_mj.benchmarks.contingency import Recomputing, run_contingency_benchmark
from jointattn_mj.cli.main import main


@pytest.fixture(autouse=True)
def small(monkeypatch):
    for name, value in (("TRANSITIONS", 400), ("RECOMPUTED", 5), ("RUN_STEPS", 200), ("SAMPLES", 1000)):
        monkeypatch.setattr(benchmark, name, value)
    monkeypatch.setattr(benchmark, "compile_seconds", lambda: (2.5, 3.5))


def test_figures(tmp_path, capsys):
    pytest.importorskip("pyinform")
    main(["benchmark", "--what", "contingency", "--blocks", "1", "--out", str(tmp_path / "figures.json")])
    figures = json.loads((tmp_path / "figures.json").read_text())
    assert figures.pop("quartiles") == {}
    assert list(figures) == [line.split()[0] for line in capsys.readouterr().out.splitlines()[1:]]
    many = {"many_short_to_pyinform", "many_short_lists_to_pyinform"}
    assert many | {"detector_to_numpy_12", "thesis_100k_s", "conditional_to_pyinform"} <= set(figures)
    for name, value in figures.items():
        assert math.isfinite(value), name
        assert value > 0, name
    assert figures["ns_per_triple_12"] == pytest.approx(1e9 / figures["detector_steps_per_s_12"] / 12)
    assert figures["ns_per_triple_300"] == pytest.approx(1e9 / figures["detector_steps_per_s_300"] / 300)
    assert figures["transfer_entropy_to_pyinform"] == pytest.approx(
        figures["transfer_entropy_ms"] / figures["pyinform_ms"]
    )
    assert (figures["compile_s"], figures["compile_wall_s"]) == (2.5, 3.5)


def test_without_pyinform(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyinform", None)
    figures = run_contingency_benchmark(1)
    missing = [name for name, value in figures.values.items() if value is None]
    assert "transfer_entropy_to_pyinform" in missing
    assert all("pyinform" in name for name in missing)
    assert figures.text({}).count("not installed") == len(missing)


@pytest.mark.parametrize("modules", benchmark.MODULES.values())
@pytest.mark.parametrize("padded", [False, True])
def test_both_ways_measure_the_same(modules, padded):
    """As many triples as it says, and the same contingency of each."""
    detecting = benchmark._Detecting(modules)
    detecting.run()
    recomputing = Recomputing(detecting.variables, padded)
    recomputing.run(*detecting.series)
    assert recomputing.values / np.log(2) == pytest.approx(detecting.watch.values, abs=1e-12)
    assert benchmark.MODULES[len(recomputing.values)] == modules


@pytest.mark.slow
def test_compiling_is_measured(monkeypatch):
    monkeypatch.undo()
    cpu, wall = benchmark.compile_seconds()
    assert cpu > 1
    assert wall > 1
