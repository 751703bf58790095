"""Arguments that are not what they have to be: one line that says what was expected."""

import pytest

from jointattn_mj import (
    ClaimResult,
    Development,
    DevelopmentResult,
    PerceptionResult,
    Session,
    SessionResult,
    Table,
    perceive,
    run_claim,
)  # fmt: skip
from jointattn_mj.errors import ConfigError

pytestmark = pytest.mark.integration

SESSION, DEVELOPMENT = Session(minutes=0.01, perception="state"), Development("fast", steps=10)


def claim(**options):
    return run_claim(**{"claim": "1.1", "out": "never", "registry": "toys.registry", **options})


WRONG = [
    (
        lambda: claim(backend="daks"),
        r"backend: expected one of loky, gpu, dask; got 'daks' \(perhaps you meant 'dask'\)",
    ),
    (lambda: claim(jobs="two"), r"jobs: expected a whole number in \[0, 10000\]; got 'two'"),
    (lambda: claim(jobs=1.5), "jobs: expected a whole number.*; got 1.5"),
    (lambda: claim(registry=3), "registry: expected a Registry.*; got 3"),
    (lambda: claim(claim=5.2), "claim: expected the id of a claim.*; got 5.2"),
    (lambda: claim(out=3), "out: expected a path; got 3"),
    (lambda: Session(minuts=3), r"Session has no option 'minuts' \(perhaps you meant 'minutes'\)"),
    (lambda: Session(preset="thesiss"), r"preset: expected one of thesis, cross_situational; .*'thesis'"),
    (lambda: Session(robot={"gaze": {"gate": "Open"}}), r"robot.gaze.gate: .* \(perhaps you meant 'open'\)"),
    (lambda: Session(caregiver="robinn"), "world.scene.caregiver: expected one of robin, .*'robin'"),
    (lambda: Development("fasst"), r"^preset: expected one of thesis, .*'fast'"),
    (lambda: Table({"a": [1]}), "arrow: expected a pyarrow.Table"),
    (lambda: SESSION.run(out=3), "out: expected a path; got 3"),
    (lambda: SESSION.run(rerun=3), "rerun: expected a path; got 3"),
    (lambda: SESSION.run(progress=3), "progress: expected a function.*; got 3"),
    (lambda: SESSION.run(kind=3), "kind: expected SessionRun or a subclass of it; got 3"),
    (lambda: DEVELOPMENT.run(out=3), "out: expected a path; got 3"),
    (lambda: DEVELOPMENT.run(progress=3), "progress: expected a function"),
    (lambda: perceive("a.mp4", ovrlay=True), r"perceive has no option 'ovrlay' \(perhaps you meant 'overlay'\)"),
    (lambda: perceive("a.mp4", out=3), "out: expected a path; got 3"),
    (lambda: perceive("a.mp4", progress=3), "progress: expected a function"),
    (lambda: perceive(3), "video: expected a path.*; got 3"),
    (lambda: ClaimResult.open(None, "5.2"), "folder: expected a path; got None"),
    *[(lambda kind=kind: kind.open(None), "folder: expected a path; got None")
      for kind in (SessionResult, DevelopmentResult, PerceptionResult)],
]  # fmt: skip


@pytest.mark.parametrize("number", range(len(WRONG)))
def test_a_wrong_argument(number, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, words = WRONG[number]
    with pytest.raises(ConfigError, match=words):
        call()
    assert list(tmp_path.iterdir()) == []


def test_a_result_is_saved_to_a_path():
    for result in (SESSION.run(), DEVELOPMENT.run()):
        with pytest.raises(ConfigError, match="folder: expected a path; got None"):
            result.save(None)
