"""OpenCV comes late, and is then like the module itself."""

import copy
import pickle

import cv2 as itself
import pytest

from jointattn_mj.cli.running import one_thread
from jointattn_mj.io.opencv import cv2


def test_it_has_what_the_module_has():
    assert cv2.matchTemplate is itself.matchTemplate and cv2.data is itself.data
    assert cv2.__version__ == itself.__version__
    with pytest.raises(AttributeError, match="no_such"):
        cv2.no_such  # noqa: B018


def test_it_is_pickled_by_name():
    assert cv2.data  # a module, which cannot be pickled
    assert pickle.loads(pickle.dumps(cv2)) is cv2
    assert copy.deepcopy({"cv2": cv2})["cv2"] is cv2


def test_where_it_is_imported_already_it_goes_on_with_one_thread():
    threads = itself.getNumThreads()
    try:
        itself.setNumThreads(2)
        one_thread()
        assert itself.getNumThreads() == 1
    finally:
        itself.setNumThreads(threads)
