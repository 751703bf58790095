"""Videos for ``perceive``: damaged, or something else under a video's name."""

import random
from collections.abc import Iterator
from pathlib import Path

from tools.reliability.inputs.damage import damaged, write
from tools.reliability.inputs.tables import as_csv, codings
from tools.reliability.malformed import Input, anything, refused


def inputs(chance: random.Random, many: int, folder: Path, film: Path) -> Iterator[Input]:
    """Videos for ``perceive``.

    Args:
        chance: Draws what is damaged, and how.
        many: Number of inputs.
        folder: For their files.
        film: A sound video.
    """
    raw = film.read_bytes()
    crafted = {
        "text.mp4": b"This is no video.\n" * 50,
        "empty.mp4": b"",
        "table.mp4": as_csv(codings()).encode(),
        "list.m3u8": f"#EXTM3U\n#EXTINF:1,\n{film}\n#EXT-X-ENDLIST\n".encode(),
        "list.mp4": f"ffconcat version 1.0\nfile {film}\n".encode(),
        "a:b.avi": b"RIFF\x00\x00\x00\x00AVI LIST",
        "http.m3u8": b"#EXTM3U\n#EXTINF:1,\nhttp://127.0.0.1:9/x.ts\n#EXT-X-ENDLIST\n",
        "image.png": b"\x89PNG\r\n\x1a\n",
    }
    for number in range(many):
        if number < len(crafted):
            name, made = list(crafted.items())[number]
            what, result = name, anything if name.startswith("list") else refused
        else:
            name, result = "table.mp4", anything
            what, made = damaged(raw, chance)
        path = write(folder / f"video{number}" / name, made)
        out = folder / f"video{number}" / "out"
        command = ("perceive", str(path), "--no-overlay", "--max-minutes", "0.1", "--out", str(out))
        yield Input("videos", what, command, result=result)
