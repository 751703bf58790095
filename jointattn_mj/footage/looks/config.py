"""Options of coding where a person looks."""

from dataclasses import dataclass
from typing import Annotated, Literal

from jointattn_mj.options import Checked, Real, Share, Whole


@dataclass(frozen=True)
class LooksConfig(Checked):
    """How looks are learned and coded. Numbers were chosen on sessions with seeds 40 to 43, 100 and 101, and tested on
    others."""

    every: Annotated[int, Whole("[1, 300]")] = 6
    """Take a look at every N-th frame: five a second. One a second codes as well; more date changes better."""
    softness: Annotated[float, Real("[1e-6, 1e6]")] = 0.1
    """Width of the activations of the map of faces, as of ``som.softness``. Narrow ones tell more directions of the
    head apart than the robot needs."""
    tuning: Annotated[float, Real("[0.01, 10]")] = 0.1
    """Standard deviation of the bump that stands for a location, in heights of the face's square: how far apart two
    locations must be to differ."""
    rounds: Annotated[int, Whole("[1, 1000]")] = 10
    """Rounds of expectation and maximisation over all looks."""
    sharpness: Annotated[float, Real("[0.1, 10]")] = 1.5
    """Weight of evidence where targets are guessed to learn from. Above 1 each direction of the head comes to mean one
    location, rather than any; otherwise somebody who never moves, such as a partner, may not be learned."""
    smoothing: Annotated[float, Real("[1e-6, 1e3]")] = 0.02
    """Added to shares before they are compared, in units of the mean share. It keeps what was seen once from being
    certain."""
    start: Literal["yaw", "alike"] = "yaw"
    """Where learning starts: from the side to which the head is turned, or with all candidates alike. In videos in
    which little is moved, learning that starts with all alike may end with locations mixed up."""
    away: Share | None = 0.3
    """Share of what evidence there is by chance that counts as low. How many looks are "away", at no object, is judged
    by how often evidence is low. Higher finds more looks away, and loses more looks at objects. With labels it is
    chosen by them. None leaves that answer out."""
    hidden: Annotated[float, Real("[-10, 10]")] = 0.8
    """Evidence for an object that is hidden, and was moved meanwhile: whoever moves something mostly looks at it."""
    partner: bool = True
    """Whether the largest other face in the image is a candidate, "partner"."""
    dwell_s: Annotated[float, Real("[0.01, 1000]")] = 4.0
    """Time for which a target is looked at on average: posteriors are smoothed forward and backward with it."""
    trust: Annotated[float, Real("(0, 1]")] = 0.5
    """Weight of each look's evidence in this smoothing; looks that follow each other err alike."""
    sure: Share = 0.8
    """Posterior from which a look counts as sure."""
    least: Share = 0.5
    """Posterior below which a look is "unsure"."""
    placements: Annotated[int, Whole("[0, 1e6]")] = 12
    """Locations at which objects must have rested in all. With fewer, nothing is coded but "unsure": where nothing
    moves, nothing tells at what somebody looks."""
    half_sure: Annotated[float, Real("[0, 1e6]")] = 12.0
    """Placements with which a posterior counts by half, the rest being spread over all targets: with few, what was
    learned may be wrong as a whole. 0 believes it at once. Labels are believed."""
    sure_alone: Share = 0.02
    """Share of looks in which one object must be sure among the objects before they are smoothed; with fewer, nothing
    is coded but "unsure"."""
    lost_s: Annotated[float, Real("[0, 1e4]")] = 1.0
    """Seconds without the face after which the answer is "cannot be seen"; shorter gaps are bridged."""
