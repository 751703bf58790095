"""Delays as people write them: in steps, or as a time."""

import re

from jointattn_mj.errors import ConfigError
from jointattn_mj.options import shown

_DELAY = re.compile(r"([0-9]{1,9}) *(?:steps?)?|([0-9]{1,9}(?:\.[0-9]{1,9})?|\.[0-9]{1,9}) *(s|ms|min)")
_SECONDS = {"s": 1.0, "ms": 0.001, "min": 60.0}


def check_delay(name: str, text: str) -> None:
    """Refuse what is no delay.

    Args:
        name: What the option is called.
        text: Steps, such as ``3``, or a time, such as ``0.5s`` or ``500ms``.

    Raises:
        ConfigError: It is neither, or 0.
    """
    match = _DELAY.fullmatch(text.strip())
    if match is None or float(match[1] or match[2]) == 0:
        raise ConfigError(f"{name}: expected steps, such as 3, or a time, such as 0.5s or 500ms; got {shown(text)}")


def delay_in_steps(name: str, text: str, step: float | None) -> int:
    """A delay in steps, to the nearest one.

    Args:
        name: What the option is called.
        text: Steps, or a time.
        step: Length of a step in seconds; None: not known.

    Raises:
        ConfigError: No delay, a time where the length of a step is not known, or one shorter than half a step.
    """
    check_delay(name, text)
    match = _DELAY.fullmatch(text.strip())
    assert match is not None
    if match[1]:
        return int(match[1])
    if step is None:
        raise ConfigError(f"{name} {text}: how long a step lasts is not known; give the {name} in steps, such as 5")
    steps = round(float(match[2]) * _SECONDS[match[3]] / step)
    if steps < 1:
        raise ConfigError(f"{name} {text} is less than half a step of {step:g} s; give at least {step:g}s")
    return steps


def lag_title(steps: int, step: float | None) -> str:
    """A lag as a title has it: the steps that were taken, and the time that they are, ``lag 5 (0.5 s)``.

    Args:
        steps: The lag.
        step: Length of a step in seconds; None: not known.
    """
    return f"lag {steps}" + ("" if step is None else f" ({steps * step:.4g} s)")
