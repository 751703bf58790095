"""Presets: readings of chapters 4 and 5, each a table and the agent that develops at it."""

from dataclasses import dataclass
from typing import Literal

from jointattn_mj.contingency.online.detector import DetectorConfig
from jointattn_mj.development.agent import DeveloperConfig
from jointattn_mj.development.table.caregiver import TableCaregiverConfig
from jointattn_mj.development.table.world import CHAPTER_4, CHAPTER_5, TableConfig


@dataclass(frozen=True)
class Preset:
    """A table and an agent, and why they are so."""

    world: TableConfig
    agent: DeveloperConfig
    why: str
    reactive: Literal["random", "curious"] = "random"
    """Initial module of the gaze."""


PRESETS = {
    "thesis": Preset(
        CHAPTER_5,
        DeveloperConfig(),
        "Chapter 5 in the text's order (the caregiver shifts, the robot observes, the robot acts); during eye "
        "contact the caregiver's neutral gaze stays.",
    ),
    "thesis_robot_first": Preset(
        TableConfig(order="robot_first", caregiver=TableCaregiverConfig(eye_contact="any", neutral_follows=True)),
        DeveloperConfig(),
        "Chapter 5 with results observed right after the action, before the caregiver answers: closer to the times of "
        "the dissertation's one example, further from its behaviour and its order.",
    ),
    "fast": Preset(
        CHAPTER_5,
        DeveloperConfig(detector=DetectorConfig(stop_rule="confidence", correction="miller_madow"), memory="reset"),
        "Counts begin anew with each module, because with it the robot behaves differently; an event is found when its "
        "estimate's standard error says so.",
    ),
    "local": Preset(
        CHAPTER_5,
        DeveloperConfig(detector=DetectorConfig(stop_rule="local")),
        "Events are ranked by how contingent they are in the situations where they hold, maps follow what is learned "
        "later, and the gaze goes where most is to be learned: the three modules within an hour of interaction.",
        reactive="curious",
    ),
    "chapter4": Preset(
        CHAPTER_4,
        DeveloperConfig(detector=DetectorConfig(measure="tc", threshold=1e-7, hold=1), most_modules=0),
        "The robot of chapter 4 acts at random, and stops to look when no T^C changes by 1e-7.",
    ),
}
