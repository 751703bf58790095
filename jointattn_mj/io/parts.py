"""The classes that a session, a development run or a watched video consists of, by name.

A checkpoint can hold objects of these and of the module that the caller names, and of nothing else: what is not on the
list is neither written nor looked up. None of them does anything when it is made without its constructor; whatever
opens files, starts programs or listens stays off the list.
"""

from importlib import import_module
from types import MemberDescriptorType
from typing import Any

PACKAGE = __name__.split(".")[0]
_CLASSES = """
contingency.online.counts: Counts
contingency.online.detector: DetectorConfig Rule Watch
contingency.online.events: Event Variable Variables
contingency.online.experience: Experience
contingency.online.local: LocalConfig
contingency.online.modules: Module ReproductionConfig
contingency.online.reactive: AvoidingModule CuriousModule RandomModule ReactiveTable
contingency.online.resolution: Growth Resolution ResolutionConfig Split Step
contingency.online.selector: Maps SelectorConfig
development.agent: Developer DeveloperConfig AgentState RecentSteps
development.contingency_log: ContingencyLog
development.looks: Looks
development.loop: Detection
development.realtime.partner: Partner PartnerConfig PartnerWorld
development.realtime.run: RealtimeConfig RealtimeRun
development.rendered.body: Body
development.rendered.continuous: ContinuousConfig ContinuousModule ContinuousRun Landing Pair
development.rendered.growing: Babbling FreeGazeBody GrowingConfig GrowingRun RecallingBody
development.rendered.run: RenderedConfig RenderedRun
development.rendered.senses: Senses SensesConfig
development.rendered.stage: Stage StageConfig
development.table.caregiver: TableCaregiverConfig Rules
development.table.run: TableRun
development.table.world: TableState TableConfig
footage.areas: AreaConfig FootageAreas Slot
footage.faces: FaceAlbum
footage.fixations: Fixation Fixations
footage.followed: FollowedFace
footage.frame_map: FrameMap
footage.interest: FaceOfInterest FaceRule
footage.likeness: Appearance
footage.people: People PeopleConfig Person Track
footage.perceiving: FootagePerception
footage.rest: Rest RestConfig
footage.sessions.camera: CameraSessionRun
footage.sessions.frames: WideFrames
footage.sessions.head: DigitalHead
footage.sessions.latency: CameraCount Latency
footage.sessions.lens: HeadConfig
footage.sessions.perceiver: WidePerception
footage.sessions.session: CodedMoment VideoSessionRun
footage.sessions.world: WideWorld
footage.shots: ShotConfig Shots
footage.spans: Span Spans
footage.watcher: Watcher
gaze_following.agent: FamiliariseConfig GazeFollower GazeShift RobotConfig
gaze_following.attention: AttentionConfig AttentionSelector
gaze_following.cross_situational: CrossSituationalLearner
gaze_following.gate: GazeConfig HeadShift
gaze_following.learners: LearnerConfig LinearLearner PopulationCode PopulationLearner
gaze_following.network_learner: NetworkLearner
gaze_following.scoring: Moment WorldMoment
gaze_following.session: SessionRun
gaze_following.shifts: Shifts
gaze_following.tables: FrameTable
gaze_following.varied_session: VariedSessionRun
io.rows: RowStore
perception.categories: FaceCategories GroupingConfig
perception.faces: FaceDetector FaceDetectorConfig FaceFix
perception.mean_face: MeanFace MeanFaceConfig
perception.motion: Motion MotionConfig MotionDetector
perception.objects: Areas ColourAreas ColourConfig
perception.percept: Percept
perception.pixels: PixelConfig PixelPerception
perception.som: SOM SOMConfig
perception.state: StateConfig StatePerception
perception.views: ViewBank
scene.caregiver: CaregiverConfig TransferScript Phase Plan
scene.delay: Past
scene.dressing: Conditions Lamp Surfaces
scene.layout: Layout LayoutConfig
scene.looker: DirectedCaregiver TableWorld
scene.model: SceneConfig
scene.movement: Arm
scene.objects: ObjectConfig
scene.people: FaceConfig
scene.sensor: Sensor
scene.world: AlignedObservation World WorldConfig WorldObservation
"""
PARTS = frozenset(
    f"{PACKAGE}.{module}.{name}"
    for module, _, names in (line.partition(": ") for line in _CLASSES.strip().splitlines())
    for name in names.split()
)
"""Dotted names. Configs of a whole run are missing: they come from the caller (see ``codec``)."""


class ForeignError(TypeError):
    """A class has no location in a checkpoint."""


def is_part(kind: type) -> bool:
    """Whether a class is on the list."""
    return f"{kind.__module__}.{kind.__qualname__}" in PARTS


def name_of(kind: type, own: str) -> str:
    """The dotted name under which a class is written.

    Raises:
        ForeignError: It is not on the list, nor of the module ``own``.
    """
    name = f"{kind.__module__}.{kind.__qualname__}"
    if class_named(name, own) is not kind:
        raise ForeignError(f"{name} does not belong into a checkpoint")
    return name


def class_named(name: str, own: str) -> type:
    """The class of a name that ``name_of`` gave.

    Raises:
        ForeignError: There is no such class, or it is not on the list, nor of the module ``own``.
    """
    module, _, short = name.rpartition(".")
    if name in PARTS or (own and module == own and not own.startswith(f"{PACKAGE}.")):
        kind = vars(import_module(module)).get(short)
        if isinstance(kind, type) and kind.__module__ == module and kind.__qualname__ == short:
            return kind
    raise ForeignError(f"{name} does not belong into a checkpoint")


def may_set(kind: type, name: Any) -> bool:
    """Whether an object of a class can have an attribute of that name: one that hides no method of its class."""
    if not isinstance(name, str) or not name.isidentifier() or name.startswith("__"):
        return False
    for base in kind.__mro__:
        if name in vars(base):
            there = vars(base)[name]
            return isinstance(there, MemberDescriptorType) or not (callable(there) or hasattr(there, "__get__"))
    return True


def is_own(kind: type, method: str, own: str) -> bool:
    """Whether the method of a class was written in the module ``own``.

    Args:
        kind: The class.
        method: Name of the method.
        own: Dotted name of the module.
    """
    return any(method in vars(base) and base.__module__ == own for base in kind.__mro__)
