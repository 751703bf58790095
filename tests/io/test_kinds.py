"""The folder of one kind of run is not opened as another."""

import pytest

from jointattn_mj import DevelopmentResult, PerceptionResult, SessionResult
from jointattn_mj.errors import OutputError

CLASSES = {
    "gaze_shifts": SessionResult,
    "steps": DevelopmentResult,
    "turns": DevelopmentResult,
    "percepts": PerceptionResult,
}


@pytest.mark.parametrize("table", CLASSES)
def test_each_is_opened_as_what_it_is(tmp_path, table):
    (tmp_path / f"{table}.parquet").write_bytes(b"")
    own = CLASSES[table]
    for kind in {SessionResult, DevelopmentResult, PerceptionResult} - {own}:
        with pytest.raises(OutputError, match=rf"is the folder of a run of \w+; open it with {own.__name__}\.open"):
            kind.open(tmp_path)
