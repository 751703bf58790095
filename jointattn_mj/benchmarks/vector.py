"""Speed of many worlds of ``follow`` in one process, beside Gymnasium's way of as many single environments."""

import time
from typing import Any

import numpy as np

from jointattn_mj.benchmarks.figures import Figures

WORLDS = 16
STEPS = {"state": 300, "images": 20}
"""Steps in a block."""
OBSERVED: dict[str, dict[str, Any]] = {"state": {"camera": False, "truth": True}, "images": {"camera": True}}
"""Arguments of the task."""


def run_vector_benchmark(blocks: int) -> Figures:
    """Measure ``FollowVector`` and ``SyncVectorEnv`` with the same actions, in turns.

    Args:
        blocks: Their number; one more, in which functions are compiled, is not counted.

    Returns:
        vector_state_steps_per_s: steps of single worlds in a second, from the state. vector_state_to_sync: beside
        SyncVectorEnv, block by block. vector_images_...: the same from images. None where Gymnasium is not installed.

    Raises:
        GLError: No image can be rendered here.
    """
    figures = Figures()
    for kind, observed in OBSERVED.items():
        pace, ratio = _paces(observed, STEPS[kind], blocks)
        figures.add(f"vector_{kind}_steps_per_s", pace)
        figures.add(f"vector_{kind}_to_sync", ratio)
    return figures


def _paces(observed: dict[str, Any], steps: int, blocks: int) -> tuple[np.ndarray | None, np.ndarray | None]:
    """Steps a second of the worlds in one process, and how many times Gymnasium's that is, (blocks,) each."""
    try:
        import gymnasium
    except ImportError:
        return None, None
    ways = None, "sync"
    worlds = [gymnasium.make_vec("jointattn_mj:Follow-v0", WORLDS, way, **observed) for way in ways]
    try:
        paces = np.array([[_pace(each, steps) for each in worlds] for _ in range(blocks + 1)])[1:]
    finally:
        for each in worlds:
            each.close()
    return paces[:, 0], paces[:, 0] / paces[:, 1]


def _pace(worlds: Any, steps: int) -> float:
    worlds.reset(seed=0)
    actions = np.random.default_rng(0).uniform(-1, 1, (steps, WORLDS, 2)).astype(np.float32)
    start = time.perf_counter()
    for action in actions:
        worlds.step(action)
    return WORLDS * steps / (time.perf_counter() - start)
