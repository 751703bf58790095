"""OpenCV, imported when something of it is first used: it takes 17 MiB, and sessions from the state do without it."""

from importlib import import_module

TYPE_CHECKING = False
if TYPE_CHECKING:
    import cv2
else:

    class _Late:
        def __getattr__(self, name):
            value = getattr(import_module("cv2"), name)
            setattr(self, name, value)
            return value

        def __reduce__(self):
            return "cv2"  # pickled by name, as a module is

    cv2 = _Late()

__all__ = ["cv2"]
