"""What is given away: wheel and source archive hold all that is needed, and the wheel works outside the checkout."""

import json
import os
import subprocess
import sys
import tarfile
import tomllib
import venv
import zipfile
from pathlib import Path

import pytest

pytestmark = pytest.mark.integration

ROOT = Path(__file__).parents[2]
wheels = pytest.importorskip("hatchling.builders.wheel", reason="the extra dev brings it")
archives = pytest.importorskip("hatchling.builders.sdist")


def tracked(*folders: str) -> set[str]:
    """Files of the repository in some folders; on the disk, for an archive has no history."""
    files = (path for folder in folders for path in (ROOT / folder).rglob("*") if path.is_file())
    return {str(path.relative_to(ROOT)) for path in files if "__pycache__" not in path.parts}


@pytest.fixture(scope="module")
def wheel(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("wheel")
    return Path(next(wheels.WheelBuilder(str(ROOT)).build(directory=str(folder), versions=["standard"])))


def test_the_wheel_has_package_assets_and_experiments_and_nothing_else(wheel):
    """Of the experiments all but figures and films, which are large."""
    with zipfile.ZipFile(wheel) as archive:
        names = {name for name in archive.namelist() if ".dist-info/" not in name}
        (entry,) = [name for name in archive.namelist() if name.endswith("entry_points.txt")]
        assert "jointattn = jointattn_mj.cli.main:main" in archive.read(entry).decode()
    experiments = {name for name in tracked("experiments") if "/figures/" not in name and not name.endswith(".mp4")}
    assert names == tracked("jointattn_mj") | {f"jointattn_mj/{name}" for name in tracked("assets") | experiments}


def test_the_source_archive_has_what_builds_tests_and_documents_it(tmp_path):
    path = Path(next(archives.SdistBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])))
    with tarfile.open(path) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    assert tracked("jointattn_mj", "assets", "experiments", "tests", "docs", "tools") <= names
    assert {"pyproject.toml", "README.md", "LICENSE", "CITATION.cff", "Makefile", "mkdocs.yml"} <= names
    assert not any("__pycache__" in name or name.startswith((".venv", "out")) for name in names)


def test_versions_agree():
    from hatchling.metadata.core import ProjectMetadata
    from hatchling.plugin.manager import PluginManager

    import jointattn_mj

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert project["dynamic"] == ["version"]  # which the builder reads from the package
    assert ProjectMetadata(str(ROOT), PluginManager()).version == jointattn_mj.__version__
    assert f"version: {jointattn_mj.__version__}\n" in (ROOT / "CITATION.cff").read_text()
    assert f"license: {project['license']}\n" in (ROOT / "CITATION.cff").read_text()


@pytest.mark.slow
def test_the_wheel_works_in_an_empty_environment(wheel, tmp_path):
    """Installs everything that the package asks for: some minutes, and a gigabyte of downloads."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTHON", "NUMBA"))}
    venv.create(tmp_path / "env", with_pip=True)
    programs = tmp_path / "env" / ("Scripts" if sys.platform == "win32" else "bin")

    def run(program: str, *arguments: object) -> str:
        command = [str(programs / program), *map(str, arguments)]
        done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
        assert done.returncode == 0, done.stderr
        return done.stdout

    run("python", "-m", "pip", "install", "--quiet", wheel)
    where = run("python", "-c", "import jointattn_mj; print(jointattn_mj.__file__)")
    assert Path(where.strip()).is_relative_to(tmp_path / "env")
    assert "5.2" in run("jointattn", "experiment", "list")
    run("jointattn", "experiment", "run", "4.7", "--runs", 1, "--out", "claims")
    run("jointattn", "session", "--minutes", 0.2, "--perception", "state", "--out", "state")
    run("jointattn", "session", "--minutes", 0.02, "--robot.familiarise.minutes", 0.02, "--out", "images", "--video")
    run("jointattn", "develop", "--preset", "fast", "--steps", 10_000, "--out", "life")
    assert json.loads((tmp_path / "images" / "summary.json").read_text())["rendered_frames"] > 0
    assert (tmp_path / "images" / "video.mp4").stat().st_size > 1000
    assert json.loads((tmp_path / "life" / "summary.json").read_text())["modules"]
