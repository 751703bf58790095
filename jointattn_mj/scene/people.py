"""Who the caregiver can be: six people, and the numbers that describe a face."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated, Literal

from jointattn_mj.options import Checked, Colour, Real, Seed, Share

Proportion = Annotated[float, Real("[0.5, 1.6]")]


@dataclass(frozen=True)
class FaceConfig(Checked):
    """One person's face. Factors are 1 for an average adult."""

    skin: Colour = (0.86, 0.67, 0.57)
    hair: Colour = (0.25, 0.17, 0.11)
    eyes: Colour = (0.32, 0.22, 0.14)
    """Colour of the iris."""
    lips: Colour = (0.72, 0.40, 0.38)
    hair_style: Literal["short", "bob", "bun", "curly", "receding"] = "short"
    width: Proportion = 1.0
    """Factor on the breadth of the head."""
    length: Proportion = 1.0
    """Factor on the height of the face below the eyes."""
    jaw: Proportion = 1.0
    """Factor on the breadth of jaw and chin."""
    nose: Proportion = 1.0
    """Factor on how far the nose stands out."""
    nose_width: Proportion = 1.0
    """Factor on the breadth of the nose."""
    lip_fullness: Proportion = 1.0
    """Factor on the height of the lips."""
    eye_size: Proportion = 1.0
    """Factor on the opening of the lids."""
    brow: Proportion = 1.0
    """Factor on the thickness of the eyebrows."""
    stubble: Share = 0.0
    """How dark the jaw is, from 0 to 1."""
    age: Share = 0.2
    """How deep folds and lines are, from 0 to 1."""
    seed: Seed = 0
    """Seed of the fine variation of skin and hair."""


IDENTITIES: dict[str, FaceConfig] = {
    "robin": FaceConfig(jaw=1.06, brow=1.1, stubble=0.35, seed=1),
    "noa": FaceConfig(
        skin=(0.90, 0.73, 0.63),
        hair=(0.34, 0.225, 0.15),
        eyes=(0.26, 0.36, 0.28),
        lips=(0.76, 0.36, 0.37),
        hair_style="bob",
        width=0.97,
        jaw=0.90,
        nose=0.88,
        lip_fullness=1.15,
        eye_size=1.12,
        brow=0.8,
        age=0.05,
        seed=2,
    ),
    "kai": FaceConfig(
        skin=(0.85, 0.66, 0.50),
        hair=(0.09, 0.08, 0.08),
        eyes=(0.17, 0.11, 0.08),
        lips=(0.68, 0.40, 0.36),
        hair_style="short",
        width=1.05,
        length=0.97,
        jaw=1.02,
        nose=0.80,
        nose_width=1.08,
        eye_size=0.88,
        age=0.1,
        seed=3,
    ),
    "amara": FaceConfig(
        skin=(0.55, 0.375, 0.28),
        hair=(0.11, 0.085, 0.075),
        eyes=(0.15, 0.09, 0.06),
        lips=(0.50, 0.25, 0.23),
        hair_style="curly",
        width=0.98,
        jaw=0.93,
        nose=0.88,
        nose_width=1.2,
        lip_fullness=1.4,
        eye_size=1.1,
        age=0.1,
        seed=4,
    ),
    "elin": FaceConfig(
        skin=(0.91, 0.74, 0.67),
        hair=(0.68, 0.66, 0.63),
        eyes=(0.33, 0.43, 0.52),
        lips=(0.72, 0.43, 0.42),
        hair_style="bun",
        width=1.0,
        length=1.02,
        jaw=0.96,
        nose=1.02,
        lip_fullness=0.8,
        brow=0.75,
        age=0.9,
        seed=5,
    ),
    "tove": FaceConfig(
        skin=(0.80, 0.61, 0.50),
        hair=(0.42, 0.40, 0.38),
        eyes=(0.25, 0.20, 0.15),
        lips=(0.64, 0.38, 0.35),
        hair_style="receding",
        width=1.02,
        length=1.04,
        jaw=1.08,
        nose=1.18,
        lip_fullness=0.75,
        brow=1.25,
        stubble=0.25,
        age=0.8,
        seed=6,
    ),
}
"""The people, by neutral first names: different skin, hair, eyes, shape and age."""
