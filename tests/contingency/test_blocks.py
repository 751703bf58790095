"""Several transitions at once, against one after the other: the same numbers to the bit."""

import numpy as np
import pytest
from worlds import series, variables

from jointattn_mj.contingency.online.blocks import LONGEST, new_block, patience, put, take_in
from jointattn_mj.contingency.online.counts import LISTED, add, empty_counts, set_joint_table
from jointattn_mj.contingency.online.detector import NOTHING, DetectorConfig, new_watch, update
from jointattn_mj.io.compiled import njit

WORLD = variables([4, 3], [3, 2], [2, 3])
EVENTS = list(WORLD.events())


@njit(cache=True)
def one_by_one(watch, counts, s, a, r, found):
    for t in range(len(found)):
        add(counts, s[t], a[t], r[t], r[t + 1], 1, len(counts.layout))
        found[t] = update(watch, counts)


@njit(cache=True)
def in_blocks(watch, counts, block, cuts, s, a, r, found):
    """Blocks as long as the stop rule lets, and not across a cut; returns their number."""
    t, blocks = 0, 0
    while t < len(found):
        n = min(patience(watch), LONGEST, cuts - t % cuts, len(found) - t)
        for i in range(n):
            put(block, i, s[t + i], a[t + i], r[t + i], r[t + i + 1])
        found[t + n - 1] = take_in(watch, counts, block, n)
        t += n
        blocks += 1
    return blocks


@pytest.mark.parametrize(
    ("options", "taken"),
    [
        ({"threshold": 4e-4}, ()),
        ({"threshold": 1e-3}, (0, 6)),
        ({"threshold": 1e-3, "modelled": "drop", "hold": 5}, (0,)),
        ({"modelled": "drop"}, tuple(range(len(EVENTS)))),
        ({"threshold": 1e-3, "stability_of": "gap", "measure": "tc", "warm_up": 0, "hold": 2}, ()),
        ({"threshold": 2e-3, "correction": "miller_madow", "hold": 50}, ()),
        ({"stop_rule": "confidence", "correction": "miller_madow", "look_again": 0.01}, ()),
    ],
    ids=str,
)
@pytest.mark.parametrize("full", [False, True])
def test_the_same_as_one_by_one(options, taken, full):
    transitions = series(WORLD, 3000, np.random.default_rng(2))
    seen, blocks = [], 0
    for cuts in (0, 100):
        counts, watch = empty_counts(WORLD, EVENTS), new_watch(DetectorConfig(**options), len(EVENTS))
        watch.modelled[list(taken)] = True
        if full:  # beyond the list of logarithms
            set_joint_table(counts, 0, np.full((2, 4, 3, 2), float(LISTED) - 20))
        found = np.full(2999, NOTHING)
        if cuts:
            block = new_block(2, 2, 2, len(counts.n))
            blocks = in_blocks(watch, counts, block, cuts, *transitions, found)
        else:
            one_by_one(watch, counts, *transitions, found)
        seen.append([part.tobytes() for part in (found, *counts, *watch[1:])])
    assert seen[0] == seen[1]
    assert blocks < 2999
