"""Inputs that make no sense, of every kind; the same for the same seed."""

import random
from pathlib import Path

from tools.reliability.inputs import calls, checkpoints, events, options, stores, tables, videos, weights
from tools.reliability.malformed import Input
from tools.reliability.subjects import film
from tools.shell import Shell

SHARES = {
    "options": 0.5,
    "calls": 0.13,
    "tables": 0.08,
    "events": 0.04,
    "checkpoints": 0.11,
    "weights": 0.06,
    "videos": 0.05,
    "stores": 0.03,
}
"""Tables, weights and videos begin with those that somebody has thought of; then come random ones."""


def all_kinds(shell: Shell, seed: int, number: int, folder: Path) -> list[Input]:
    """About ``number`` inputs; their files are made in ``folder``.

    Args:
        shell: Runs commands.
        seed: Of all draws.
        number: About how many inputs there are to be.
        folder: For their files.
    """
    chance = random.Random(seed)
    many = {kind: max(1, round(share * number)) for kind, share in SHARES.items()}
    clip = film(folder / "clip.mp4", 90)
    table = folder / "codings.csv"
    table.write_text(tables.as_csv(tables.codings()))
    session = events.session_of(shell, folder / "session")
    places = {
        "{video}": str(clip),
        "{table}": str(table),
        "{store}": str(folder / "no_store"),
        "{session}": str(session),
        "{events}": str(events.events_of(shell, session, "elan", folder / "elan")),
    }
    return [
        *options.inputs(shell, chance, many["options"], folder / "options", places),
        *calls.inputs(chance, many["calls"]),
        *tables.inputs(chance, many["tables"], folder / "tables"),
        *events.inputs(shell, chance, many["events"], folder / "events"),
        *weights.inputs(shell, chance, many["weights"], folder / "weights"),
        *checkpoints.inputs(shell, chance, many["checkpoints"], folder / "checkpoints", clip),
        *videos.inputs(chance, many["videos"], folder / "videos", clip),
        *stores.inputs(shell, chance, many["stores"], folder / "stores"),
    ]
