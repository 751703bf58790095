"""Pages that mkdocs makes from the repository: the claims from experiments/README.md, the API from docstrings."""

import re
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "jointattn_mj"
FIGURES = ROOT / "experiments" / "figures"


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """List a page of the API for every folder of the package."""
    section = next(part["API"] for part in config.nav if "API" in part)
    section += [{_dotted(folder): _page(folder)} for folder in _folders()]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what is not in docs/."""
    files.append(File.generated(config, "claims.md", content=_claims()))
    for figure in sorted(FIGURES.iterdir()):
        files.append(File.generated(config, f"figures/{figure.name}", abs_src_path=str(figure)))
    for folder in _folders():
        files.append(File.generated(config, _page(folder), content=_api(folder)))
    lines = [f"- [`{_dotted(folder)}`]({Path(_page(folder)).name})" for folder in _folders()]
    files.append(File.generated(config, "api/index.md", content="\n".join(["# API, from the docstrings", "", *lines])))
    return files


def _folders() -> list[Path]:
    """The package and its sub-packages."""
    return sorted(path.parent for path in PACKAGE.rglob("__init__.py"))


def _dotted(folder: Path) -> str:
    return ".".join(folder.relative_to(ROOT).parts)


def _page(folder: Path) -> str:
    return f"api/{_dotted(folder)}.md"


def _api(folder: Path) -> str:
    """A heading and all modules of a folder."""
    modules = [f"{_dotted(folder)}.{path.stem}" for path in sorted(folder.glob("*.py")) if path.stem != "__init__"]
    parts = [f"::: {name}\n" for name in modules]
    head = f"::: {_dotted(folder)}\n    options:\n      members: false\n      heading_level: 1\n"
    return "\n".join([head, *parts])


def _claims() -> str:
    """experiments/README.md; links to other files of the repository become their names."""
    text = (ROOT / "experiments" / "README.md").read_text("utf-8")
    return re.sub(r"(?<!!)\[([^]]+)\]\((?!figures/|https?:|#)[^)]+\)", r"`\1`", text)
