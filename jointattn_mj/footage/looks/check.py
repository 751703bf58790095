"""Codes of a person: to be compared with (Cohen's kappa by seconds, with its interval), or to be learned from."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from jointattn_mj.errors import SeriesError
from jointattn_mj.footage.looks.coding import UNSEEN, UNSURE
from jointattn_mj.footage.looks.tables import TIER
from jointattn_mj.recordings.agreement import AgreementOptions, agreement
from jointattn_mj.recordings.events import Events
from jointattn_mj.recordings.intervals import intervals_of
from jointattn_mj.recordings.reader import read

LEFT_OUT = (UNSURE, UNSEEN, "turn")
"""Codes that are no answer to where somebody looks: time in which either coder has one is left out."""


@dataclass(frozen=True)
class Codings:
    """Where somebody looks, as one coder has coded it.

    Attributes:
        path: The file.
        looks: Onset and offset, s, and code of each look, in order; without what is no answer.
        seconds: Time that was coded, with what is no answer.
    """

    path: Path
    looks: tuple[tuple[float, float, str], ...]
    seconds: float

    @classmethod
    def read(cls, path: Path) -> "Codings":
        """Read codings.

        Args:
            path: A file with one tier, or with one that is called "looks at". Codes are names of objects, and "away";
                time with "unsure", "turn" or "cannot be seen" is left out. Columns onset_s and offset_s are seconds.

        Raises:
            SeriesError: It cannot be read, has not one such tier of one recording, or looks overlap on it.
        """
        events = read(path).events
        tiers = events.tier_names
        if TIER not in tiers and len(tiers) != 1:
            raise SeriesError(f"{path} must have one tier, or one called {TIER!r}; it has {', '.join(tiers) or 'none'}")
        if len(events.recordings) != 1:
            raise SeriesError(f"{path} must be of one recording; it has {len(events.recordings)}")
        own = intervals_of(events, events.recordings[0], TIER if TIER in tiers else tiers[0])
        looks = [
            (float(onset), float(offset), str(code))
            for onset, offset, code in zip(own.onset, own.offset, own.code, strict=True)
            if code
        ]
        answers = tuple(look for look in looks if look[2] not in LEFT_OUT)
        return cls(path, answers, sum(offset - onset for onset, offset, _ in looks))

    def check_codes(self, names: tuple[str, ...], all_of_them: bool) -> None:
        """Check that codes are names of what can be looked at, before a video is watched for them.

        Args:
            names: What can be looked at.
            all_of_them: Whether each must be; else one of them will do, for a person codes more than that.

        Raises:
            SeriesError: They are not.
        """
        codes = {code for _, _, code in self.looks}
        strange = sorted(codes - set(names))
        if strange and (all_of_them or len(strange) == len(codes)):
            code, which = ("code", "is") if len(strange) == 1 else ("codes", "are")
            raise SeriesError(
                f"{self.path}: the {code} {', '.join(map(repr, strange))} {which} none of {', '.join(names)}; name the "
                "objects as they are coded: NAME=#colour"
            )

    def at(self, times: np.ndarray, names: tuple[str, ...]) -> np.ndarray:
        """What was coded at some times.

        Args:
            times: (n,) s, ascending.
            names: Codes that are meant.

        Returns:
            (n,) index among the names; -1 where nothing was coded.

        Raises:
            SeriesError: A code is none of these, or nothing was coded at any of the times.
        """
        codes = np.full(len(times), -1)
        for onset, offset, code in self.looks:
            if code not in names:
                raise SeriesError(f"{self.path}: the code {code!r} is none of {', '.join(names)}")
            codes[np.searchsorted(times, onset) : np.searchsorted(times, offset)] = names.index(code)
        if not (codes >= 0).any():
            raise SeriesError(f"{self.path} has no look between {times[0]:.1f} and {times[-1]:.1f} s of the video")
        return codes

    def compare(self, other: "Codings") -> dict[str, Any]:
        """Agreement with another coder, wherever both say where somebody looks.

        Args:
            other: The other coder.

        Returns:
            ``kappa``, ``low`` and ``high`` (its 95% interval, by blocks of 30 s; NaN where kappa has no meaning, as
            with one code alone), ``observed`` (share of seconds that agree), ``seconds`` that were compared,
            ``left_out`` (share of the time coded here that was not), and ``kappa_by_code``. Where there is no such
            time, ``seconds`` is 0 and nothing else is known.
        """
        pairs = sorted(
            (max(a, c), min(b, d), own, given)
            for a, b, own in self.looks
            for c, d, given in other.looks
            if min(b, d) > max(a, c)
        )
        if not pairs:
            unknown = dict.fromkeys(("kappa", "low", "high", "observed"), math.nan)
            return {**unknown, "seconds": 0.0, "left_out": 1.0, "kappa_by_code": {}}
        onsets, offsets, at = [], [], 0.0
        for onset, offset, *_ in pairs:  # laid end to end, so that what is left out is no code of its own
            onsets.append(at)
            at += offset - onset
            offsets.append(at)
        tier = [TIER] * len(pairs)
        first = Events.of(tier, [own for _, _, own, _ in pairs], onsets, offsets)
        second = Events.of(tier, [given for _, _, _, given in pairs], onsets, offsets)
        agreed = agreement(first, second, options=AgreementOptions(step=min(1.0, at)))[0]
        low, high = agreed.interval
        return {
            "kappa": agreed.kappa,
            "low": low,
            "high": high,
            "observed": agreed.observed,
            "seconds": round(at, 1),
            "left_out": round(max(0.0, 1 - at / self.seconds), 4),
            "kappa_by_code": agreed.by_code(),
        }
