"""Files to which something has happened."""

import random
from pathlib import Path


def damaged(raw: bytes, chance: random.Random) -> tuple[str, bytes]:
    """The bytes of a file after something has happened to them, and what."""
    place = chance.randrange(max(1, len(raw)))
    length = chance.choice((1, 4, 64, 4096))
    noise = bytes(chance.randrange(256) for _ in range(length))
    made = {
        "cut off": raw[:place],
        "beginning lost": raw[place:],
        "overwritten": raw[:place] + noise + raw[place + length :],
        "zeroed": raw[:place] + bytes(length) + raw[place + length :],
        "inserted": raw[:place] + noise + raw[place:],
        "part lost": raw[:place] + raw[place + length :],
        "part doubled": raw[: place + length] + raw[place:],
        "a bit turned": raw[:place] + bytes([raw[place] ^ (1 << chance.randrange(8))]) + raw[place + 1 :],
        "longer": raw + noise,
        "empty": b"",
        "noise": bytes(chance.randrange(256) for _ in range(512)),
    }
    how = chance.choice(list(made))
    return f"{how} at {place}", made[how]


def write(path: Path, raw: bytes) -> Path:
    """Make a file and its folder."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(raw)
    return path
