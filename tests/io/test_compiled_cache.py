"""Compiled functions are stored where numba stores them, and are current as long as all that they consist of is."""

import os
import pickle
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from jointattn_mj.io import compiled

pytestmark = pytest.mark.integration

INNER = "from toy.compiled import njit\n\n@njit(cache=True)\ndef inner():\n    return {}\n"
OUTER = """
from toy.compiled import njit
from toy.inner import inner

@njit(cache=True)
def outer():
    return inner()
"""
ALLOCATES = """
import numpy as np
from toy.compiled import njit

@njit(cache=True)
def inner(n):
    if n < 0:
        raise ValueError("expected 0 or more; got", n)
    return np.sort(np.linspace(n, 0.0, 5))
"""
ASK = "from toy.outer import outer; print(outer(), sum(outer.stats.cache_hits.values()))"


@pytest.fixture
def toy(tmp_path) -> Path:
    """A package with a function that is inlined into one of another file."""
    package = tmp_path / "toy" / "toy"
    (package / "io").mkdir(parents=True)
    (package / "__init__.py").write_text("")
    text = Path(compiled.__file__).read_text().replace("parents[1]", "parents[0]")
    (package / "compiled.py").write_text(text)
    (package / "inner.py").write_text(INNER.format(1))
    (package / "outer.py").write_text(OUTER)
    return package


def said(package: Path, code: str = ASK, **environment: str) -> str:
    kept = {name: value for name, value in os.environ.items() if name != "NUMBA_CACHE_DIR"}
    done = subprocess.run(
        [sys.executable, "-c", code],
        env={**kept, "PYTHONPATH": str(package.parent), **environment},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


def test_what_was_inlined_from_a_changed_file_is_compiled_again(toy):
    """numba alone would go on with the old mixture."""
    assert [said(toy), said(toy)] == ["1 0", "1 1"]
    (toy / "words.py").write_text("'No compiled code.'\n")
    assert said(toy) == "1 1"
    (toy / "inner.py").write_text(INNER.format(2))
    for index in (toy / "__pycache__").glob("*.nbi"):
        with index.open("r+b") as file:
            pickle.load(file)  # the version
            file.write(b"ctoy.outer\nGone\n.")  # a class that is not there any more
            file.truncate()
    assert [said(toy), said(toy)] == ["2 0", "2 1"]


def test_a_folder_that_is_named(toy, tmp_path):
    named = tmp_path / "mine"
    assert [said(toy, NUMBA_CACHE_DIR=str(named)) for _ in range(2)] == ["1 0", "1 1"]
    assert list(named.rglob("outer*.nbi"))
    assert not (toy / "__pycache__").exists() or not list((toy / "__pycache__").glob("*.nbi"))


def test_where_nothing_can_be_written(toy):
    shutil.rmtree(toy / "__pycache__", ignore_errors=True)
    (toy / "__pycache__").write_text("in the way")
    nowhere = str(toy / "outer.py")
    assert [said(toy, HOME=nowhere, XDG_CACHE_HOME=nowhere) for _ in range(2)] == ["1 0", "1 0"]


def test_functions_of_others_are_left_alone(tmp_path):
    """Importing the package changes neither the environment nor where numba stores what a user compiles."""
    code = """
import os
before = dict(os.environ)
import jointattn_mj, numba
import jointattn_mj.perception.som
from mine import own
own()
print(os.environ == before, repr(numba.config.CACHE_DIR), os.path.basename(own._cache.cache_path))
"""
    (tmp_path / "mine.py").write_text("import numba\n\n@numba.njit(cache=True)\ndef own():\n    return 1\n")
    root = str(Path(compiled.__file__).parents[2])
    assert said(tmp_path / "x", code, PYTHONPATH=f"{tmp_path}:{root}") == "True '' __pycache__"


def test_stored_functions_need_little_of_numba(toy):
    """Those that allocate arrays and raise errors, too; what is compiled after them works as ever."""
    (toy / "inner.py").write_text(ALLOCATES)
    ask = (
        "import sys; from toy.inner import inner; print(inner(8).tolist(), 'scipy.linalg' in sys.modules)\n"
        "try: inner(-1)\nexcept ValueError as error: print(*error.args)\n"
        "from toy.compiled import njit; print(njit(lambda n: inner(n).sum())(8))"
    )
    end = ["expected 0 or more; got -1", "20.0"]
    assert said(toy, ask).splitlines() == ["[0.0, 2.0, 4.0, 6.0, 8.0] True", *end]
    assert said(toy, ask).splitlines() == ["[0.0, 2.0, 4.0, 6.0, 8.0] False", *end]


def test_a_function_that_borrows(toy):
    """Both of its forms are stored; Python calls the one that lets go of a generator."""
    text = """
import numpy as np
from toy.compiled import njit

@njit(cache=True, borrows=True)
def drawn(random):
    return random.random()

@njit(cache=True)
def twice(random):
    return drawn(random) + drawn(random)
"""
    (toy / "outer.py").write_text(text)
    ask = (
        "import sys, numpy as np; from toy.outer import drawn, twice; random = np.random.default_rng(0); "
        "drawn(random); before = sys.getrefcount(random); print(drawn(random) < 1, twice(random) < 2, "
        "sys.getrefcount(random) - before, sum(drawn._counted.stats.cache_hits.values()))"
    )
    assert [said(toy, ask) for _ in range(2)] == ["True True 0 0", "True True 0 1"]
    assert len(list((toy / "__pycache__").glob("outer.drawn*.nbi"))) == 2
