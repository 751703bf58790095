"""Figures of a run: the right curves and marks, names beside and not upon them, the same bytes every time."""

import cv2
import numpy as np
import pytest

from jointattn_mj.contingency.online.events import Event
from jointattn_mj.contingency.online.modules import Module
from jointattn_mj.development import figures
from jointattn_mj.development.behaviour import BEHAVIOURS, phases
from jointattn_mj.development.contingency_log import ContingencyLog
from jointattn_mj.development.figures import Made, MapImage, draw_behaviour, draw_contingency, draw_maps
from jointattn_mj.development.table.world import TableConfig, table_variables

VARIABLES = table_variables(TableConfig())
NAMES = [VARIABLES.describe(event) for event in VARIABLES.events()]


@pytest.fixture
def drawn(monkeypatch):
    """Figures as they were before they became files."""
    kept = []
    save = figures.save
    monkeypatch.setattr(figures, "save", lambda figure, path, **more: (kept.append(figure), save(figure, path, **more)))
    return kept


def noted(table, every=100):
    """As if it had been noted every 100 steps."""
    log = ContingencyLog(every, table.shape[1])
    for row in table:
        log.free()[0] = row
        log.fill(1)
    return log


def values(n_steps=60):
    """Event 2 is the highest, 7 the second, then 5 overtakes both; 11 begins late, 0 is negative, others are low."""
    table = np.full((n_steps, len(NAMES)), 1e-4)
    table[:, 2], table[:, 7] = 0.02, 0.01
    table[n_steps // 2 :, 5] = 0.05
    table[: n_steps // 2, 11] = np.nan
    table[:, 0] = -0.01
    return table


MADE = [Made(1500, 2, "gaze following (FG-m)"), Made(4000, 5, "gaze alternation (SC-m)")]


def draw(path, made=MADE, n_steps=60):
    draw_contingency(path, noted(values(n_steps)), NAMES, made, "SAC (bits)")


def legend_texts(figure):
    return [text.get_text() for text in figure.legends[0].get_texts()]


class TestContingency:
    def test_events_in_the_legend(self, drawn, tmp_path):
        """Those that were ever one of the two highest, modules first, in the order in which they were made."""
        draw(tmp_path / "sac.png")
        assert legend_texts(drawn[0]) == [f"1: {NAMES[2]}", f"2: {NAMES[5]}", NAMES[7]]

    def test_axes(self, drawn, tmp_path):
        draw(tmp_path / "sac.png")
        axes = drawn[0].axes[0]
        assert (axes.get_yscale(), axes.get_ylabel(), axes.get_xlabel()) == ("log", "contingency: SAC (bits)", "steps")
        assert axes.get_xlim() == (0, 6000)

    def test_triangles(self, drawn, tmp_path):
        """Black, upside down, where modules were made."""
        draw(tmp_path / "sac.png")
        triangles = [line for line in drawn[0].axes[0].get_lines() if line.get_marker() == "v"]
        assert [line.get_xdata()[0] for line in triangles] == [1500, 4000]
        assert {line.get_color() for line in triangles} == {"k"}

    def test_ends_where_nothing_new_comes(self, drawn, tmp_path):
        draw(tmp_path / "sac.png", MADE[:1])
        axes = drawn[0].axes[0]
        assert axes.get_xlim() == (0, 3000)
        assert "first of 6,000" in axes.get_xlabel()

    @pytest.mark.parametrize("n_steps", [0, 1, 2])
    def test_short_runs(self, tmp_path, n_steps):
        draw(tmp_path / "sac.png", [], n_steps)
        assert cv2.imread(str(tmp_path / "sac.png")) is not None

    def test_nothing_above_zero(self, tmp_path):
        draw_contingency(tmp_path / "sac.png", noted(np.zeros((1, len(NAMES)))), NAMES, [], "SAC (bits)")
        assert cv2.imread(str(tmp_path / "sac.png")) is not None

    def test_few_events_are_named(self, drawn, tmp_path):
        """Of those without a module, as many as there are pale colours; the rest share one line of the legend."""
        table = np.full((60, len(NAMES)), 1e-4)
        for row in range(60):
            table[row, row % 12] = 0.02
        draw_contingency(tmp_path / "sac.png", noted(table), NAMES, [], "SAC (bits)")
        assert len(legend_texts(drawn[0])) == figures.MOST_NAMED + 1
        assert legend_texts(drawn[0])[-1] == "6 other events"


class TestBehaviour:
    found = np.random.default_rng(0).integers(0, 6, 6000)

    def draw(self, path, found=found, made=MADE):
        draw_behaviour(path, found, phases(found, [detection.step for detection in made]), made)

    def test_curves_and_phases(self, drawn, tmp_path):
        self.draw(tmp_path / "behaviour.png")
        axes = drawn[0].axes[0]
        words = " ".join(legend_texts(drawn[0]))
        assert all(name in words for name in BEHAVIOURS)
        assert [text.get_text() for text in axes.texts] == ["P1", "P2", "P3"]
        curves = [line for line in axes.get_lines() if len(line.get_xdata()) > 2]
        assert len(curves) == 6
        assert np.allclose(sum(line.get_ydata() for line in curves), 1)
        assert curves[0].get_xdata()[[0, -1]].tolist() == [1000, 6000]
        dashed = [line.get_xdata()[0] for line in axes.get_lines() if line.get_linestyle() == "--"]
        assert dashed == [1500, 4000]

    @pytest.mark.parametrize("n_steps", [1, 3, 999])
    def test_short_runs(self, tmp_path, n_steps):
        self.draw(tmp_path / "behaviour.png", self.found[:n_steps], [])
        assert cv2.imread(str(tmp_path / "behaviour.png")) is not None


def map_image(commands):
    command, reliability = np.full((2, 5), -1), np.zeros((2, 5))
    for pair, value in commands.items():
        command[pair], reliability[pair] = value, 2 + pair[1]
    return MapImage("1: a title", Module(Event(0, 0, 2), command, reliability, command, command), VARIABLES)


class TestMaps:
    def test_one(self, drawn, tmp_path):
        """Reliability stands where the row of the observables meets the column of the command."""
        draw_maps(tmp_path / "maps.png", [map_image({(0, 1): 3, (1, 2): 0})])
        axes = drawn[0].axes[0]
        marks = {text.get_position(): text.get_text() for text in axes.texts}
        assert marks == {(3, 1): "3.00", (0, 7): "4.00"}
        assert axes.get_yticklabels()[7].get_text() == "object: yes, caregiver's face: at spot 3"
        assert [label.get_text() for label in axes.get_xticklabels()] == ["spot 1", "spot 2", "spot 3", "caregiver"]

    @pytest.mark.parametrize("count", [0, 1, 6])
    def test_many(self, tmp_path, count):
        draw_maps(tmp_path / "maps.png", [map_image({(0, 0): 1})] * count)
        assert cv2.imread(str(tmp_path / "maps.png")) is not None

    def test_empty_map(self, drawn, tmp_path):
        draw_maps(tmp_path / "maps.png", [map_image({})])
        assert not drawn[0].axes[0].texts


def test_legends_cover_no_curve(drawn, tmp_path):
    draw(tmp_path / "sac.png")
    TestBehaviour().draw(tmp_path / "behaviour.png")
    for figure in drawn:
        axes, legend = figure.axes[0].get_window_extent(), figure.legends[0].get_window_extent()
        assert not axes.overlaps(legend)
        assert legend.x0 >= 0 and legend.x1 <= figure.bbox.x1 and legend.y0 >= 0


def test_titles_say_what_one_sees(drawn, tmp_path):
    """Equations stand at the axes or below."""
    draw(tmp_path / "sac.png")
    TestBehaviour().draw(tmp_path / "behaviour.png")
    draw_maps(tmp_path / "maps.png", [map_image({(0, 0): 1})])
    titles = [figure.get_suptitle() for figure in drawn]
    assert titles == [
        "Which events are contingent, and when each became a module",
        "What the robot does with its gaze as modules are added",
        "What each module does next, given what is sensed",
    ]


def test_same_bytes(tmp_path):
    for name in ("one.png", "two.png"):
        draw(tmp_path / name)
    assert (tmp_path / "one.png").read_bytes() == (tmp_path / "two.png").read_bytes()
