"""What agents earn: episodes, tables, files, refusals."""

import json

import cv2
import numpy as np
import pytest

from jointattn_mj.cli.play import PlayOptions, environment_for, table
from jointattn_mj.tasks.agents import AGENTS
from jointattn_mj.viewing.play import Episode, play_episodes

pytestmark = pytest.mark.integration


def played(task: str, agent: str, episodes: int = 2, seed: int = 0) -> list[Episode]:
    options = PlayOptions(task, agent, episodes, seed)
    environment = environment_for(options)
    found = play_episodes(environment, AGENTS[agent](environment, seed), episodes)
    environment.close()
    return found


def test_oracle_earns_all_of_follow():
    found = played("follow", "oracle")
    assert [(episode.episode, episode.steps) for episode in found] == [(1, 30), (2, 30)]
    assert all(episode.reward_a_step > 0.95 and episode.reward_sum == episode.reward_a_step * 30 for episode in found)


def test_chance_earns_less_and_goes_by_its_seed():
    first, same, other = (played("follow", "random", 4, seed) for seed in (0, 0, 1))
    assert first == same != other
    assert np.mean([episode.reward_a_step for episode in first]) < 0.5


def test_the_developer_goes_on_from_episode_to_episode():
    options = PlayOptions("turn_taking", "developer", 2)
    environment = environment_for(options)
    agent = AGENTS["developer"](environment, 0)
    found = play_episodes(environment, agent, 2)
    assert agent.agent.state.n_steps[0] == 2000
    assert all(0.1 < episode.reward_a_step < 0.6 for episode in found)
    assert environment.task.world.rendered_frames == 0


def test_table_tells_mean_and_interval():
    found = [Episode(number, 30, value, value / 30) for number, value in enumerate((10.0, 20.0, 30.0), 1)]
    text = table(PlayOptions("follow", "zero", 3), found)
    assert "zero in follow, seed 0" in text
    assert "mean return 20.0 [" in text
    assert len([line for line in text.splitlines() if line.strip().startswith(("1 ", "2 ", "3 "))]) == 3
    assert "interval" not in table(PlayOptions("follow", "zero", 1), found[:1])


def test_results_in_a_folder(jointattn, tmp_path):
    options = ("follow_hard", "--agent", "oracle", "--episodes", 2, "--seed", 3, "--out", tmp_path / "results")
    outcome = jointattn("play", *options)
    assert (outcome.code, outcome.err) == (0, "")
    assert "oracle in follow_hard, seed 3" in outcome.out
    left = json.loads((tmp_path / "results" / "episodes.json").read_text())
    assert left["config"]["agent"] == "oracle"
    assert left["versions"]["mujoco"]
    assert [row["steps"] for row in left["rows"]] == [60, 60]
    assert left["mean_return"]["mean"] == pytest.approx(np.mean([row["reward_sum"] for row in left["rows"]]))
    assert (tmp_path / "results" / "episodes.csv").read_text().count("\n") == 3
    again = jointattn("play", *options)
    assert again.code == 2
    assert "is there already" in again.err


@pytest.mark.parametrize("task", ["turn_taking", "follow_hard"])
def test_video(jointattn, tmp_path, task):
    outcome = jointattn("play", task, "--agent", "zero", "--episodes", 1, "--video", "--out", tmp_path / task,
                        "--time-limit", 6.0)  # fmt: skip
    assert (outcome.code, outcome.err) == (0, "")
    film = cv2.VideoCapture(str(tmp_path / task / "video.mp4"))
    images = []
    while (read := film.read())[0]:
        images.append(read[1])
    assert len(images) == {"turn_taking": 6, "follow_hard": 60}[task]
    assert film.get(cv2.CAP_PROP_FPS) == pytest.approx({"turn_taking": 2, "follow_hard": 10}[task])
    assert images[0].shape == (480, 1480, 3)
    assert images[0].std() > 10


BAD = [
    (("peekaboo", "--agent", "zero"), ("peekaboo", "object_transfer")),
    (("follow", "--agent", "nobody"), ("nobody", "oracle")),
    (("follow",), ("--agent",)),
    (("follow", "--agent", "zero", "--episodes", 0), ("episodes", "0")),
    (("follow", "--agent", "zero", "--seed", -1), ("seed", "-1")),
    (("follow", "--agent", "zero", "--time-limit", 0), ("time_limit", "0")),
    (("follow", "--agent", "zero", "--video"), ("--out",)),
    (("follow", "--agent", "gaze_follower"), ("gaze_follower", "object_transfer")),
    (("object_transfer", "--agent", "developer"), ("developer", "turn_taking")),
]


@pytest.mark.parametrize(("options", "words"), BAD, ids=lambda value: " ".join(map(str, value)))
def test_what_cannot_be_done(jointattn, options, words):
    outcome = jointattn("play", *options)
    assert outcome.code == 2
    assert outcome.err.count("\n") == 1
    for word in words:
        assert word in outcome.err


def test_the_trained_robot_earns_more_than_chance():
    """A quarter of an episode from images: it follows the caregiver now and then, which chance does not."""
    options = PlayOptions("object_transfer", "gaze_follower", 1, time_limit=20.0)
    environment = environment_for(options)
    (episode,) = play_episodes(environment, AGENTS["gaze_follower"](environment, 0), 1)
    environment.close()
    assert episode.reward_a_step > 0.05  # random: .016
