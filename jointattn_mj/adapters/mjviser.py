"""A show in the browser: the scene in 3D, drawn by mjviser, and the robot's view beside it."""

import copy
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from http import HTTPStatus
from io import StringIO
from typing import Any

import numpy as np

from jointattn_mj.errors import ExtraError
from jointattn_mj.io.extras import extra
from jointattn_mj.scene.model import ROBOT_GROUP
from jointattn_mj.viewing.guard import names_of, refusal
from jointattn_mj.viewing.show import Show, in_real_time

viser = extra("view", "viser")
mjviser = extra("view", "mjviser")

CAMERA, LOOKS_AT = (0.3, -1.9, 1.6), (0.75, 0.0, 0.85)
"""Position of the camera at first, and the point it looks at; world frame, metres. Robot and caregiver are in view."""
WALLS = ("room/wall", "room/side_walls")
_SHOWN_GROUP, _HIDDEN_GROUP = 0, 5
_LINE_M = 0.008


class _Server(viser.ViserServer):  # type: ignore[misc, name-defined]
    """A server that no page can ask for a public address, as viser's own pages and those of other sites could."""

    def request_share_url(self, verbose: bool = True) -> str | None:
        """Share nothing."""
        return None


@contextmanager
def _guarded(host: str) -> Iterator[None]:
    """Let a viser server that is started in the block answer its own pages only; viser has no option for that.

    Raises:
        ExtraError: This version of viser starts its server in another way.
    """
    from websockets.asyncio import server

    names, serve, guarded = names_of(host), server.serve, []

    def guarded_serve(*arguments: Any, process_request: Any = None, **options: Any) -> Any:
        def process(connection: Any, request: Any) -> Any:
            reason = refusal(request.headers, names)
            if reason is not None:
                return connection.respond(HTTPStatus.FORBIDDEN, f"Refused: {reason}.\n")
            return process_request(connection, request)

        guarded.append(process)
        return serve(*arguments, process_request=process, **options)

    server.serve = guarded_serve
    try:
        yield
    finally:
        server.serve = serve
    if not guarded:
        raise ExtraError("this version of viser cannot be kept from other pages; pip install 'jointattn-mj[view]'")


class Browser:
    """Serves a show to browsers.

    Attributes:
        address: URL of the page.
    """

    def __init__(self, show: Show, host: str, port: int):
        """Start the server.

        Args:
            show: What is shown.
            host: Interface to listen on; whoever reaches it can watch, and pause or restart the show.
            port: The first port to try; the next free one is taken.

        Raises:
            ExtraError: This version of viser cannot be kept from answering other pages.
        """
        self._show = show
        with _guarded(host), redirect_stdout(StringIO()):  # it draws a box around the address
            self._server: Any = _Server(host=host, port=port, label="jointattn view")
        self.address = f"http://{host}:{self._server.get_port()}"
        gui, camera = self._server.gui, self._server.initial_camera
        gui.configure_theme(control_width="large", dark_mode=True, show_share_button=False)
        gui.main_panel.dock_right()
        camera.position, camera.look_at, camera.up = CAMERA, LOOKS_AT, (0.0, 0.0, 1.0)
        self._eye = gui.add_image(show.eye(), label="What the robot sees", jpeg_quality=85)
        self._words = gui.add_markdown(show.words())
        self._paused = gui.add_checkbox("Pause", initial_value=False, hint="Stop the simulation")
        self._restart = gui.add_button("Next episode", hint="End this episode and start the next one")
        self._asked = False
        self._restart.on_click(lambda event: setattr(self, "_asked", True))
        self._model: Any = None
        self.draw()

    def run(self, goes_on: Callable[[], bool]) -> None:
        """Advance and draw until ``goes_on`` says no; nothing advances while no browser is connected."""
        try:
            in_real_time(self._show, self.draw, goes_on, self._waits)
        finally:
            self._server.stop()

    def _waits(self) -> bool:
        return not self._server.get_clients() or (self._paused.value and not self._asked)

    def draw(self) -> None:
        """Send the present frame to all browsers."""
        if self._asked:
            self._asked = False
            self._show.restart()
        world = self._show.world
        if world.model is not self._model:
            self._model = world.model
            self._rebuild()
        self._scene.update_from_mjdata(world.data)
        for number, (sight, colour) in enumerate(self._show.sights()):
            points, colours = np.array([[sight.start, sight.end]]), np.array(colour, np.uint8)
            self._server.scene.add_line_segments(f"/sight/{number}", points, colours, thickness=_LINE_M)
        self._eye.image = self._show.eye()
        self._words.content = self._show.words()

    def _rebuild(self) -> None:
        """Draw another caregiver's scene, with the robot's body and without walls, which would block the view."""
        model = copy.copy(self._model)
        model.geom_group[model.geom_group == ROBOT_GROUP] = _SHOWN_GROUP
        for wall in WALLS:
            model.geom(wall).group = _HIDDEN_GROUP
        self._server.scene.reset()
        self._scene = mjviser.ViserMujocoScene(self._server, model, num_envs=1)
        self._scene.camera_tracking_enabled = False
