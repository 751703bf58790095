"""Three minutes with a caregiver, and then faces that the map has not seen (section 6.4.1, Fig. 6.6)."""

import base64
import zlib
from dataclasses import replace
from typing import Any

import numpy as np

from jointattn_mj.gaze_following.session import SessionConfig, SessionRun
from jointattn_mj.perception.som import standardised
from jointattn_mj.sweeps.claim import Setting

EVERY = 3
"""Frames between two of the faces that test the map: ten a second, as in learning."""
SHUFFLES = 100


def session_config(caregiver: str) -> SessionConfig:
    """Three more minutes with this caregiver, from images."""
    config = SessionConfig(minutes=3.0)
    scene = replace(config.world.scene, caregiver=caregiver)
    return replace(config, world=replace(config.world, scene=scene))


SETTINGS = {name: Setting(session_config(name), 3) for name in ("robin", "noa", "kai", "amara", "elin", "tove")}
"""By caregiver."""
FIRST_SEED = 1000


def trial(config: SessionConfig, seed: int) -> dict[str, Any]:
    """Trial: how well the map keeps neighbours together, and what a position on it says about the face.

    ``topographic_error`` is the share of new faces whose nearest and second nearest units do not touch, and
    ``shuffled_error`` the same with the units shuffled; ``yaw_r2`` and ``pitch_r2`` the share of the variance of the
    head's angles that a quadratic function of row and column explains; ``pictures`` the units' patterns (Fig. 6.6).
    """
    session = SessionRun(replace(config, seed=seed))
    patterns, angles = [], []

    def look(session: SessionRun) -> None:
        robot = session.robot
        face = robot.face
        if robot.percept is None or session.frame % EVERY or robot.attended != face or not robot.percept.visible[face]:
            return
        patterns.append(standardised(robot.perceiver.face_pattern()))
        angles.append(session.world.face_angles_deg())

    try:
        session.begin()
        while session.frame < session.total:
            session.step(look)
        som, visible, turned = session.robot.som, np.array(patterns), np.array(angles)
    finally:
        session.close()
    winners = np.array([som.winner(pattern) for pattern in visible])
    nearest = np.array([np.argsort(np.square(som.weights - pattern).sum(axis=1))[:2] for pattern in visible])
    rng = np.random.default_rng(seed)
    shuffled = [apart(rng.permutation(len(som.weights))[nearest], som.config.columns) for _ in range(SHUFFLES)]
    rows, columns = np.divmod(winners, som.config.columns)
    yaw, pitch = turned.T
    return {
        "faces": len(visible),
        "topographic_error": som.topographic_error(visible),
        "shuffled_error": float(np.mean(shuffled)),
        "cells_used": len(np.unique(winners)),
        "yaw_r2": explained(rows, columns, yaw),
        "pitch_r2": explained(rows, columns, pitch),
        "pictures": packed(som.images()),
    }


def apart(pairs: np.ndarray, columns: int) -> float:
    """Share of ``pairs`` (n, 2) of units that do not touch; diagonals count as touching."""
    location = np.stack(np.divmod(pairs, columns), axis=-1)
    return float(np.mean(np.abs(location[:, 0] - location[:, 1]).max(axis=1) > 1))


def explained(rows: np.ndarray, columns: np.ndarray, angle: np.ndarray) -> float:
    """R^2 of a quadratic function of the position on the map, (n,) each.

    Args:
        rows: (n,) rows of the units.
        columns: (n,) their columns.
        angle: (n,) angle of the head whose face each unit stands for, deg.
    """
    terms = np.stack([np.ones(len(rows)), rows, columns, rows * columns, rows**2, columns**2], axis=1)
    rest = angle - terms @ np.linalg.lstsq(terms, angle, rcond=None)[0]
    return float(1 - rest.var() / angle.var())


def packed(images: np.ndarray) -> str:
    """(rows, columns, side, side) as text, each image stretched to 0..255."""
    low, high = images.min(axis=(2, 3), keepdims=True), images.max(axis=(2, 3), keepdims=True)
    grey = np.round(255 * (images - low) / np.maximum(high - low, 1e-9)).astype(np.uint8)
    return base64.b64encode(zlib.compress(grey.tobytes(), 9)).decode()


def unpacked(text: str, rows: int, columns: int) -> np.ndarray:
    """What :func:`packed` was given, as grey values.

    Args:
        text: Base64 of the compressed grey values.
        rows: Of the map.
        columns: Of the map.
    """
    grey = np.frombuffer(zlib.decompress(base64.b64decode(text)), np.uint8)
    side = round((len(grey) / (rows * columns)) ** 0.5)
    return grey.reshape(rows, columns, side, side)
