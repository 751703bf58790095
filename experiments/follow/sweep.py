"""PPO of Stable-Baselines3 on the task ``follow`` and its hard form, by what the learner observes."""

from dataclasses import dataclass, replace
from typing import Annotated, Any

from jointattn_mj.options import Checked, Real, Share, Whole
from jointattn_mj.sweeps.claim import Setting


@dataclass(frozen=True)
class Training(Checked):
    """What is learned, what is observed, and where PPO departs from the defaults of Stable-Baselines3.

    Angles of the robot's head are observed in any case.
    """

    environment: str
    """Name in Gymnasium's registry."""
    truth: bool
    """Whether yaw and pitch of the caregiver's head are observed: the attended object follows from them."""
    image_height: Annotated[int, Whole("[1, 1000]")] | None = None
    """Height of the grey image that is observed, in pixels; None: no image. Images are not stacked: the caregiver's
    gaze rests, and the face stays in view while the robot looks at the table."""
    patch_side: Annotated[int, Whole("[1, 32]")] | None = None
    """Side of the face patch that is observed, in pixels: of the 32 that the robot's face detector cuts out; None: no
    patch."""
    steps: Annotated[int, Whole("[0, 1e10]")] = 12_288
    """Of experience, over all copies of the environment."""
    every: Annotated[int, Whole("[1, 1e10]")] = 1024
    """Steps between two tests; a multiple of ``copies * rollout``."""
    episodes: Annotated[int, Whole("[1, 1e6]")] = 50
    """Episodes of each test, the same each time; the learner practises in others."""
    copies: Annotated[int, Whole("[1, 1024]")] = 8
    """Environments at once, one after the other in one process."""
    learning_rate: Annotated[float, Real("(0, 1]")] = 1e-3
    """Three times the default: with the state observed, little is to be learned."""
    rollout: Annotated[int, Whole("[1, 1e6]")] = 64
    """Steps in each copy between two updates: two episodes of ``follow``."""
    batch: Annotated[int, Whole("[1, 1e6]")] = 128
    """Steps in a batch; a quarter of an update."""
    epochs: Annotated[int, Whole("[1, 1e6]")] = 10
    """How often an update goes through its steps; the default."""
    discount: Share = 0.8
    """gamma; the head has turned after some three steps, and then an action has brought what it brings."""
    trace: Share = 0.9
    """lambda of the advantage's estimate."""
    spread: Annotated[float, Real("(0, 100]")] = 0.37
    """Standard deviation of actions at the beginning; their bounds are -1 and 1."""


STATE = Training("Follow-v0", truth=True)
PATCH = replace(STATE, truth=False, patch_side=16, steps=6144)
"""Half of the patch's resolution is enough to tell the gaze, and quicker to learn from."""
IMAGES = replace(STATE, truth=False, image_height=60)
HARD = replace(STATE, environment="FollowHard-v0", steps=102_400, every=10_240)
SETTINGS = {
    "follow/state": Setting(STATE, 10),
    "follow/patch": Setting(PATCH, 10),
    "follow/blindfolded": Setting(replace(STATE, truth=False), 10),
    "follow/images": Setting(IMAGES, 10),
    "follow_hard/state": Setting(HARD, 10),
    "follow_hard/patch": Setting(replace(HARD, truth=False, patch_side=16, every=20_480), 10),
    "follow_hard/images": Setting(replace(HARD, truth=False, image_height=60, steps=20_480, every=5120), 10),
    "follow_hard/blindfolded": Setting(replace(HARD, truth=False, steps=20_480, every=5120), 10),
}
"""Task, a slash, what is observed. Blindfolded, all that can be learned is where objects tend to lie, and that is soon
learned: in the hard form, in a fifth of the steps. From whole images little more is."""
FIRST_SEED = 50_000
"""Parameters were chosen while looking at seeds 0 and 1."""


def trial(config: Training, seed: int) -> dict[str, Any]:
    """The curve of a run of training, and baselines on the same episodes.

    Raises:
        ExtraError: Stable-Baselines3 is not installed; it is the extra ``rl``.
    """
    from .training import train

    return train(config, seed)
