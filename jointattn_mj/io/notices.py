"""What somebody should know while the work goes on."""

import sys

from tqdm import tqdm


def notice(text: str) -> None:
    """Say ``text`` in one line on stderr, without breaking a progress bar."""
    tqdm.write(f"jointattn: {text}", file=sys.stderr)
