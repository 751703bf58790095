"""Claims, their verdicts, and the registry that imports them when asked."""

import sys

import pytest
from toys.registry import REGISTRY

from jointattn_mj.errors import ConfigError
from jointattn_mj.sweeps.claim import Claim, Setting, Verdict
from jointattn_mj.sweeps.registry import Entry, Registry

R, P, N, E, U = Verdict.REPRODUCED, Verdict.PARTLY, Verdict.NOT, Verdict.EXTENSION, Verdict.UNDECIDED


@pytest.mark.parametrize(
    ("verdicts", "overall"),
    [
        ([R, R], R),
        ([R, U, E], R),
        ([N, E], N),
        ([R, N], P),
        ([R, P], P),
        ([E, E], E),
        ([E, U], U),
        ([U], U),
        ([], U),
    ],
)
def test_verdict_of_several(verdicts, overall):
    assert Verdict.of_all(verdicts) is overall


def test_a_claim_needs_settings():
    parts = {"id": "1", "title": "", "source": "", "says": "", "trial": max, "analyse": max, "draw": max}
    with pytest.raises(ConfigError, match="at least one setting"):
        Claim(settings={}, **parts)
    with pytest.raises(ConfigError, match=r"runs: .*; got -1"):
        Setting({}, -1)


def test_registry_imports_what_is_asked_for():
    for name in ("toys.broken.sweep", "toys.coin.analysis"):
        sys.modules.pop(name, None)
    assert list(REGISTRY) == ["1.1", "1.2"]
    coin = REGISTRY["1.1"]
    assert (coin.id, coin.first_seed, coin.version, coin.film) == ("1.1", 0, 1, None)
    assert set(coin.settings) == {"fair", "loaded"}
    assert not {"toys.broken.sweep", "toys.coin.analysis"} & sys.modules.keys()
    assert coin.analyse({})[0].what == "a sentence"
    broken = REGISTRY["1.2"]
    assert (broken.first_seed, broken.version) == (5, 3)


def test_ids_differ():
    entry = Entry("1", "coin", "", "", "")
    with pytest.raises(ConfigError, match="must differ"):
        Registry("toys", entry, entry)
