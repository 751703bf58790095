"""Every way from Python into compiled code, with numbers that it must not be given: each is one named error.

Compiled code looks numbers up wherever they point, and a mistake is a segmentation fault. So everything is tried in a
process of its own, which this file is as a program.
"""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator

import numpy as np
import pytest

pytestmark = pytest.mark.integration

NAN, HUGE = float("nan"), 2**62
Case = tuple[str, Callable[[], object]]


def codes() -> Iterator[Case]:
    """Series of codes: measures of whole recordings."""
    from jointattn_mj.contingency import measures
    from jointattn_mj.contingency.discovery import discover
    from jointattn_mj.contingency.granger import linear_granger
    from jointattn_mj.contingency.local import local_contingency
    from jointattn_mj.contingency.scan import scan_lags
    from jointattn_mj.contingency.series import joint, recode
    from jointattn_mj.contingency.significance import adjust, assess

    fine = np.arange(20) % 3
    wrong = {
        "negative": fine - 1, "NaN": np.where(fine == 1, NAN, fine), "infinite": np.where(fine == 1, np.inf, fine),
        "fractions": fine / 2, "none": [], "one": [1], "text": list("abc" * 7)[:20], "Nones": [None] * 20,
        "complex": fine + 1j, "objects": np.array([object()] * 20), "beyond 64 bits": [10**30] * 20,
        "unsigned and huge": np.full(20, 2**63, np.uint64), "two dimensions": np.zeros((20, 2), int), "number": 3,
        "another length": fine[:-3], "masked": np.ma.masked_equal(fine, 1), "dates": fine.astype("datetime64[D]"),
        "nothing": None, "ragged": [[0, 1], [0]],
    }  # fmt: skip
    for name, given in wrong.items():
        for measure in (
            measures.transfer_entropy, measures.mutual_information, measures.pointwise_transfer_entropy, linear_granger,
        ):  # fmt: skip
            yield f"{measure.__name__} of {name}", lambda m=measure, g=given: m(g, fine)
            yield f"{measure.__name__} for {name}", lambda m=measure, g=given: m(fine, g)
        for three in (
            measures.combined_transfer_entropy, measures.state_action_contingency,
            measures.pointwise_combined_transfer_entropy, measures.contingent_saliency, local_contingency,
        ):  # fmt: skip
            yield f"{three.__name__} with {name}", lambda m=three, g=given: m(fine, g, fine)
        yield f"assess {name}", lambda g=given: assess("transfer_entropy", g, fine)
        data = {"s": fine, "a": given, "r": fine}
        yield f"discover {name}", lambda d=data: discover(d, ["s"], ["a"], ["r"])
        if name != "another length":
            yield f"joint {name}", lambda g=given: joint(g, fine)
            yield f"recode {name}", lambda g=given: recode(g)
    for groups in ([NAN], [0.5], [0, 0, 0], ["a", "b"], [[0], [0, 1]]):
        yield f"groups {groups}", lambda g=groups: assess("transfer_entropy", fine, fine, groups=g)
    for odd in (None, -1, NAN, 0.5, "a", b"a", {0: 1}, [[0], [0, 1]], np.array(0.5), [None], (i for i in range(2))):
        if not isinstance(odd, list):  # numpy makes seeds of lists
            yield f"seed {odd}", lambda s=odd: assess("transfer_entropy", fine, fine, seed=s)
        yield f"lags {odd}", lambda s=odd: scan_lags("transfer_entropy", fine, fine, lags=s)
        yield f"p-values {odd}", lambda s=odd: adjust(s, "none")
    yield "adjust by an array", lambda: adjust([0.5], np.zeros(2))
    yield "corrected by an array", lambda: measures.transfer_entropy(fine, fine, correction=np.zeros(2))
    for base in (1, 0, -2, NAN, "2", None):
        yield f"base {base}", lambda b=base: measures.transfer_entropy(fine, fine, base=b)
    for surrogates in (0, -1, 1.5, NAN, "9"):
        yield (
            f"surrogates {surrogates}",
            lambda n=surrogates: measures.transfer_entropy(fine, fine, correction="shuffle", surrogates=n),
        )


def agents() -> Iterator[Case]:
    """Counts, detector, selector and agents, transition by transition."""
    from jointattn_mj.contingency.online.blocks import LONGEST, new_block, take_in
    from jointattn_mj.contingency.online.counts import add, divide, empty_counts, local_variance, set_joint_table
    from jointattn_mj.contingency.online.detector import DetectorConfig, new_watch, update
    from jointattn_mj.contingency.online.events import Variable, Variables
    from jointattn_mj.contingency.online.reactive import RandomModule
    from jointattn_mj.contingency.online.selector import SelectorConfig, flat_maps, select
    from jointattn_mj.contingency.permutation import hypergeometric, tables
    from jointattn_mj.development.agent import Developer

    world = Variables(
        (Variable("s0", tuple("abc")), Variable("s1", tuple("ab"))), (Variable("a0", tuple("abcd")),),
        (Variable("r0", tuple("ab")), Variable("r1", tuple("abc"))),
    )  # fmt: skip
    events = list(world.events())
    counts = empty_counts(world, events)
    fine = {"s": np.array([2, 1]), "a": np.array([3]), "r": np.array([1, 2]), "r_next": np.array([0, 0])}
    add(counts, *fine.values(), 1, len(counts.layout))

    def transition(weight=1, contexts=None, **changed):
        every = len(counts.layout) if contexts is None else contexts
        return lambda: add(counts, *(fine | changed).values(), weight, every)

    for part in fine:
        for name, values in {
            "negative": fine[part] - 9, "too high": fine[part] + 4, "huge": np.full(len(fine[part]), HUGE),
            "floats": fine[part] * 1.0, "NaN": np.full(len(fine[part]), NAN), "a list": fine[part].tolist(),
            "nothing": fine[part][:0], "too few": fine[part][:-1], "None": None, "square": fine[part][None],
        }.items():  # fmt: skip
            yield f"add {part} {name}", transition(**{part: values})
    for weight in (0, 2, -2, NAN, np.inf, -1.5, 0.0):
        yield f"add weight {weight}", transition(weight=weight)
    yield "add what was never there, taken out", transition(weight=-1, s=np.array([0, 0]))
    for contexts in (-1, 10**6):
        yield f"add {contexts} contexts", transition(contexts=contexts)
    for event in (-1, len(events), HUGE, 0.5, NAN):
        yield f"variance of event {event}", lambda e=event: local_variance(counts, e, 1)
    for weight in (0, -1.0, NAN, np.inf):
        yield f"divide by {weight}", lambda w=weight: divide(counts, w)
    shape = (2, 3, 4, 2)
    for name, table in {
        "NaN": np.full(shape, NAN), "negative": np.full(shape, -1.0), "another shape": np.zeros((2, 2)), "None": None,
    }.items():  # fmt: skip
        yield f"joint table {name}", lambda t=table: set_joint_table(counts, 0, t)
    yield "update with another number of events", lambda: update(new_watch(DetectorConfig(), len(events) + 3), counts)
    watch, block = new_watch(DetectorConfig(), len(events)), new_block(2, 1, 2, len(counts.n))
    for n in (0, LONGEST + 1):
        yield f"a block of {n}", lambda n=n: take_in(watch, counts, block, n)
    yield "a block of another world", lambda: take_in(watch, counts, new_block(2, 1, 2, 1), 1)
    high = new_block(2, 1, 2, len(counts.n))
    high.s[0] = 200
    yield "a block with a high value", lambda: take_in(watch, counts, high, 1)
    maps = flat_maps(world, [], [RandomModule("a0").table(world)], SelectorConfig())
    working = {"strength": np.zeros(1), "a": np.zeros(1, np.int64), "driver": np.zeros(1, np.int64)}

    def choose(s=fine["s"], r=fine["r"], **changed):
        return lambda: select(maps, s, r, np.random.default_rng(0), *(working | changed).values())

    for name, s in {"negative": np.array([-5, 0]), "high": np.array([9, 0]), "none": np.zeros(0, int)}.items():
        yield f"select under {name}", choose(s=s)
    for part in working:
        yield f"select without room for {part}", choose(**{part: working[part][:0]})
    for odds in (np.full((3, 4), NAN), np.full((3, 4), -1.0), np.zeros((3, 0)), np.full((3, 4), 0.25).tolist()[:2]):
        yield f"odds {np.shape(odds)}", lambda o=odds: flat_maps(world, [], [Born(o).table(world)], SelectorConfig())
    agent = Developer(world)
    for name, (s, r) in {
        "high": ([3, 0], [0, 0]), "negative": ([-1, 0], [0, 0]), "NaN": ([NAN, 0], [0, 0]), "few": ([0], [0, 0]),
        "ragged": ([[0], [1, 2]], [0, 0]), "text": (["a", "b"], [0, 0]), "results": ([0, 0], [0, HUGE]),
        "None": (None, [0, 0]),
    }.items():  # fmt: skip
        yield f"developer {name}", lambda s=s, r=r: agent.act(s, r)
    for draw in ((-1, 3, 1), (3, 3, 9), (10**6, 1, 1), (1, HUGE, 1)):
        yield f"hypergeometric {draw}", lambda d=draw: hypergeometric(*d, tables(10)[1], 0.5)


class Born:
    """A reactive module with odds of one's own."""

    def __init__(self, odds):
        self.odds = odds

    def table(self, variables):
        from jointattn_mj.contingency.online.reactive import ReactiveTable

        return ReactiveTable("a0", "s0", self.odds, 1.0)


def tables_and_turns() -> Iterator[Case]:
    """The symbolic table, its caregiver, and the robot of the earlier work."""
    from jointattn_mj.baselines.turn_taking.agent import TurnTaker, TurnTakerConfig, feedback_target
    from jointattn_mj.baselines.turn_taking.attempts import AttemptSituations, run_attempts
    from jointattn_mj.baselines.turn_taking.faces import FaceInputs
    from jointattn_mj.development.table.caregiver import rules, shift_gaze
    from jointattn_mj.development.table.world import CHAPTER_4, CHAPTER_5, new_table, step
    from jointattn_mj.scene.movement import Arm, rotation_to_zyx

    for config in (CHAPTER_4, CHAPTER_5):
        table, s, r = new_table(config, np.random.SeedSequence(0)), np.zeros(2, int), np.zeros(2 + config.profile, int)
        step(table, np.array([0, 0]), s, r)
        for name, a in {
            "negative": np.array([-1, 0]), "high": np.array([config.spots + 1, 0]), "huge": np.array([HUGE, 0]),
            "lowest": np.array([np.iinfo(np.int64).min, 0]), "NaN": np.array([NAN, 0]), "none": np.zeros(0, int),
            "a list": [0, 0], "None": None,
        }.items():  # fmt: skip
            yield f"turn {name}", lambda t=table, a=a, s=s, r=r: step(t, a, s, r)
        yield "turn without sensors", lambda t=table, r=r: step(t, np.array([0, 0]), np.zeros(0, int), r)
        yield "turn without results", lambda t=table, s=s: step(t, np.array([0, 0]), s, np.zeros(0, int))
        yield "turn of no table", lambda t=table, s=s, r=r: step(tuple(t), np.array([0, 0]), s, r)
        full = np.ones(config.spots, bool)
        for looks in ((-1, 0, 0), (0, -1, 0), (99, 0, 0), (0, 99, 0), (0, 0, 99), (0, 0, -9), (0, NAN, 0)):
            yield (
                f"shift_gaze {looks}",
                lambda looks=looks, full=full, config=config: shift_gaze(
                    rules(config.caregiver), full, *looks, np.random.default_rng(0), full.copy()
                ),
            )
    robot = TurnTaker(TurnTakerConfig(hidden=4), 6, np.random.default_rng(0))
    face, head = np.ones(6, np.float32), np.zeros(2)
    robot.movement(face, head), robot.learn(face, head[None], head[None])
    for name, wrong in {"long": np.ones(900, np.float32), "NaN": face * NAN, "text": "face", "none": face[:0]}.items():
        yield f"movement for a {name} face", lambda f=wrong: robot.movement(f, head)
        yield f"learning of a {name} face", lambda f=wrong: robot.learn(f, head[None], head[None])
    yield "movement from one angle", lambda: robot.movement(face, np.zeros(1))
    yield "learning of unequal pairs", lambda: robot.learn(face, np.zeros((5, 2)), np.zeros((3, 2)))
    yield "learning of NaN", lambda: robot.learn(face, head[None], head[None] * NAN)
    for kept in (-2, 3, HUGE):
        yield f"target {kept}", lambda k=kept: feedback_target(1, np.ones(3, bool), np.ones(3), np.ones(3), k, False)
    yield "target among few", lambda: feedback_target(0, np.ones(9, bool), np.ones(3), np.ones(3), 0, True)
    bank = FaceInputs(np.ones((3, 6), np.float32), np.zeros((3, 2)), np.zeros(6), 1.0)
    for index in (-1, 3, HUGE):
        locations = AttemptSituations(np.zeros((2, 2, 2)), np.full((2, 2), index))
        yield (
            f"attempts with face {index}",
            lambda p=locations: run_attempts(robot, p, bank, 3, np.random.default_rng(0)),
        )
    nowhere = AttemptSituations(np.full((2, 2, 2), NAN), np.zeros((2, 2), int))
    yield "attempts nowhere", lambda: run_attempts(robot, nowhere, bank, 3, np.random.default_rng(0))
    empty = FaceInputs(np.ones((0, 6), np.float32), np.zeros((0, 2)), np.zeros(6), 1.0)
    yield "faces of an empty bank", lambda: empty.of_locations(np.zeros((2, 2)), 0.0, np.random.default_rng(0))
    yield "faces for nowhere", lambda: bank.of_locations(np.full((2, 2), NAN), 0.0, np.random.default_rng(0))
    arm = Arm(np.zeros(3), 0.3, 0.3, np.zeros(3), np.eye(3))
    yield "an arm with too few swings", lambda: arm.reach(np.ones((500, 3)), np.zeros(2))
    yield "an arm in the plane", lambda: arm.reach(np.ones((3, 2)), np.zeros(3))
    yield "no rotation", lambda: rotation_to_zyx(np.zeros((1, 1)))


def images() -> Iterator[Case]:
    """Whatever perceives images or learns from patterns."""
    from jointattn_mj.gaze_following.attention import AttentionConfig, AttentionSelector
    from jointattn_mj.gaze_following.learners import LearnerConfig, Locations, make_learner
    from jointattn_mj.perception.faces import FaceDetector
    from jointattn_mj.perception.gray import fill_gray
    from jointattn_mj.perception.motion import MotionDetector
    from jointattn_mj.perception.objects import ColourAreas
    from jointattn_mj.perception.percept import StillObservation
    from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
    from jointattn_mj.perception.som import SOM, SOMConfig
    from jointattn_mj.scene.objects import OBJECTS

    rgb = np.array([item.rgb for item in OBJECTS[:4]])
    perception, colours, head = PixelPerception(PixelConfig(), rgb), ColourAreas(rgb), np.zeros(2)
    fine = np.random.default_rng(0).integers(0, 256, (48, 64, 3), np.uint8)
    odd = {
        "no pixels": fine[:0], "no columns": fine[:, :0], "grey": fine[..., 0], 
        "four channels": np.dstack([fine, fine[..., :1]]),
        "floats": fine / 255, "NaN": fine * NAN, "16 bits": fine.astype(np.uint16), "bool": fine > 9,
        "mirrored": fine[:, ::-1], "every second": fine[::2, ::2], "Fortran": np.asfortranarray(fine),
        "a list": fine.tolist(), "text": "image", "None": None, "a batch": fine[None],
    }  # fmt: skip
    for name, image in odd.items():
        yield f"look at {name}", lambda p=image: perception.perceive(StillObservation(p, head), True)
        yield f"segment {name}", lambda p=image: colours.segment(p)
        yield f"labels of {name}", lambda p=image: colours.labels(p)
        yield f"gray of {name}", lambda p=image: fill_gray(p, np.zeros((48, 64), np.uint8), 0, 0, 64, 48)
    for name, angles in {
        "NaN": head * NAN, "three": np.zeros(3), "None": None, "far": np.array([1e9, 0]), "a list": [0.0, 0.0],
        "bool": head > 1, "masked": np.ma.array(head, mask=[True, False]),
    }.items():  # fmt: skip
        yield f"look with angles {name}", lambda a=angles: perception.perceive(StillObservation(fine, a), True)
    yield "look at nothing", lambda: perception.perceive({}, True)
    yield "a pattern before any face", lambda: PixelPerception(PixelConfig(), rgb).face_pattern()
    for name, gray in {"smaller": np.zeros((9, 9), np.uint8), "floats": np.zeros((48, 64))}.items():
        yield f"gray into {name}", lambda g=gray: fill_gray(fine, g, 0, 0, 64, 48)
        yield f"areas into {name}", lambda g=gray: colours.find(fine, g, colours.nothing())
    yield "gray from NaN", lambda: fill_gray(fine, np.zeros((48, 64), np.uint8), NAN, 0, 64, 48)
    few = ColourAreas(rgb[:1]).nothing()
    yield "areas of other colours", lambda: colours.find(fine, np.zeros((48, 64), np.uint8), few)
    for name, colour in {"NaN": rgb * NAN, "255": rgb * 255, "none": rgb[:0], "grey": rgb[:, :2]}.items():
        yield f"colours {name}", lambda c=colour: ColourAreas(c)
    for name, gray in {"colour": fine, "no pixels": fine[:0, :, 0], "floats": fine[..., 0] / 1.0, "None": None}.items():
        yield f"motion in {name}", lambda g=gray: MotionDetector().update(g, None, colours.nothing())
        yield f"faces in {name}", lambda g=gray: FaceDetector().detect(g)
    gray = np.ascontiguousarray(fine[..., 0])
    for box in (
        (NAN,) * 4, (0, 0), "box", (0.5, 0, 9, 9), 5, {1: 2, 3: 4}, {1, 2, 3, 4}, iter((1, 2, 3, 4)), (True,) * 4,
        (2**70,) * 4, (0, 0, HUGE, 9),
    ):  # fmt: skip
        yield f"motion of a face at {box}", lambda b=box: MotionDetector().update(gray, b, colours.nothing())
    som = SOM(1024, SOMConfig(rows=3, columns=3), np.random.default_rng(0))
    pattern = np.random.default_rng(0).random((32, 32))
    for name, wrong in {
        "NaN": pattern * NAN, "infinite": pattern * np.inf, "small": pattern[1:], "text": "abc", "None": None,
        "complex": pattern * 1j, "ragged": [[1], [2, 3]],
    }.items():  # fmt: skip
        for act in (som.update, som.winner, som.activations):
            yield f"{act.__name__} of {name}", lambda a=act, p=wrong: a(p)
    yield "train on nothing", lambda: som.train(np.zeros((0, 1024)), np.random.default_rng(0))
    yield "train on NaN", lambda: som.train(np.full((3, 1024), NAN), np.random.default_rng(0))
    for code in ("population", "linear", "cross_situational"):
        learner = make_learner(LearnerConfig(code=code), 9, np.random.default_rng(0))
        active = np.full(9, 1 / 9)
        for name, wrong in {
            "NaN": active * NAN,
            "few": active[:3],
            "many": np.ones(500),
            "text": "a",
            "None": None,
        }.items():
            yield f"{code} learns {name}", lambda n=learner, w=wrong: n.learn(w, Locations.only(head))
            yield f"{code} predicts {name}", lambda n=learner, w=wrong: n.predict(w)
        for name, wrong in {"NaN": head * NAN, "one": head[:1], "None": None}.items():
            yield f"{code} learns command {name}", lambda n=learner, w=wrong, a=active: n.learn(a, Locations.only(w))
        for name, wrong in {"NaN": NAN * np.zeros((3, 2)), "flat": head, "None": None, "text": "a"}.items():
            yield f"{code} scores {name}", lambda n=learner, w=wrong, a=active: n.score(a, Locations(w))
    selector = AttentionSelector(AttentionConfig(), 4, np.random.default_rng(0))
    for name, moves in {
        "few": np.zeros(2, bool),
        "none": np.zeros(0, bool),
        "floats": np.zeros(5),
        "a list": [False] * 5,
    }.items():
        yield f"attention to {name}", lambda m=moves: selector.advance(0, m)


def harmless() -> Iterator[Case]:
    """Odd, and right: read-only images, one pixel, sizes that change between two looks, all sorts of integers."""
    from jointattn_mj.contingency.measures import transfer_entropy
    from jointattn_mj.perception.motion import MotionDetector
    from jointattn_mj.perception.objects import ColourAreas
    from jointattn_mj.perception.percept import StillObservation
    from jointattn_mj.perception.pixels import PixelConfig, PixelPerception
    from jointattn_mj.scene.objects import OBJECTS

    rgb, head = np.array([item.rgb for item in OBJECTS[:4]]), np.zeros(2)
    perception, rng = PixelPerception(PixelConfig(), rgb), np.random.default_rng(0)
    for height, width in ((240, 320), (1, 1), (1, 500), (500, 1), (7, 9), (240, 320), (31, 33), (480, 640), (16, 16)):
        image = rng.integers(0, 256, (height, width, 3), np.uint8)
        image.flags.writeable = False
        look = StillObservation(image, head)
        yield (
            f"look at {height} x {width}",
            lambda o=look: [perception.perceive(o, landed) for landed in (True, False, False)],
        )
    motion, colours = MotionDetector(), ColourAreas(rgb)
    for shape in ((240, 320), (20, 30), (240, 320)):
        gray = rng.integers(0, 256, shape, np.uint8)
        yield f"motion in {shape}", lambda g=gray: motion.update(g, (-50, -50, 10**6, 10**6), colours.nothing())
    for dtype in ("bool", "int8", "uint8", "int32", "uint64", "float16", "float32"):
        series = (np.arange(20) % 2).astype(dtype)
        yield f"series of {dtype}", lambda s=series: transfer_entropy(s[::-1], s)


def walk() -> None:
    """Try everything; a line for each says what came of it."""
    from jointattn_mj.errors import JointAttnError

    for part in (codes, agents, tables_and_turns, images, harmless):
        for name, act in part():
            print(json.dumps([part.__name__, name]), end=" ", flush=True)
            try:
                act()
                outcome = "nothing"
            except JointAttnError as error:
                outcome = "named" if "\n" not in str(error) else f"several lines: {error}"
            except BaseException as error:
                outcome = f"{type(error).__name__}: {str(error)[:200]}"
            print(json.dumps(outcome), flush=True)


def test_what_compiled_code_must_not_be_given_is_a_named_error():
    done = subprocess.run([sys.executable, __file__], capture_output=True, text=True, timeout=900)
    lines = done.stdout.splitlines()
    assert done.returncode == 0, f"it died with {done.returncode} at {lines[-1:]}: {done.stderr[-500:]}"
    decoder, amiss = json.JSONDecoder(), []
    for line in lines:
        (part, name), end = decoder.raw_decode(line)
        outcome = json.loads(line[end:])
        if outcome != ("nothing" if part == "harmless" else "named"):
            amiss.append(f"{part}, {name}: {outcome}")
    assert not amiss, "\n".join(amiss)
    assert len(lines) > 400


if __name__ == "__main__":
    walk()
