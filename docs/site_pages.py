"""Pages that mkdocs makes from the repository: the claims from experiments/, the API from docstrings."""

import html
import re
import sys
from pathlib import Path

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "jointattn_mj"
EXPERIMENTS = ROOT / "experiments"
if str(ROOT) not in sys.path:
    sys.path.insert(0, str(ROOT))

from experiments.pages import BEGIN, END  # noqa: E402
from experiments.registry import REGISTRY  # noqa: E402

LABELS = ("", "dissertation", "here", "n", "")
"""What stands before the values of a row where the columns are stacked, on a phone."""


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    """List a page for every claim, and a page of the API for every folder of the package."""
    sections = {title: pages for part in config.nav for title, pages in part.items()}
    sections["What the dissertation claims"] += [
        {f"{claim}: {entry.title}": f"claims/{entry.folder}.md"} for claim, entry in REGISTRY.entries.items()
    ]
    sections["API"] += [{_dotted(folder): _page(folder)} for folder in _folders()]
    return config


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add what is not in docs/."""
    files.append(File.generated(config, "claims/index.md", content=_linked(EXPERIMENTS / "README.md")))
    for entry in REGISTRY.entries.values():
        page = _linked(EXPERIMENTS / entry.folder / "README.md")
        files.append(File.generated(config, f"claims/{entry.folder}.md", content=_stacking(page)))
    for film in sorted(EXPERIMENTS.glob("*/*.mp4")):
        files.append(File.generated(config, f"claims/{film.name}", abs_src_path=str(film)))
    for figure in sorted((EXPERIMENTS / "figures").iterdir()):
        files.append(File.generated(config, f"figures/{figure.name}", abs_src_path=str(figure)))
    for folder in _folders():
        files.append(File.generated(config, _page(folder), content=_api(folder)))
    lines = [f"- [`{_dotted(folder)}`]({Path(_page(folder)).name})" for folder in _folders()]
    files.append(File.generated(config, "api/index.md", content="\n".join(["# API, from the docstrings", "", *lines])))
    return files


def on_page_content(content: str, **_: object) -> str:
    """Let every figure open by itself, where a phone can enlarge it, and no option be broken after its dashes."""
    content = re.sub(r'<img [^>]*src="([^"]+)"[^>]*>', r'<a href="\1">\g<0></a>', content)
    return re.sub(r"(?<=<code>)[^<]*--[^<]*(?=</code>)", _with_whole_options, content)


def _with_whole_options(code: re.Match[str]) -> str:
    """Inline code in which no option is broken. The longest fits the line of a phone."""
    return re.sub(r"--[a-z][\w-]*(\.[\w-]+)*", r'<span class="option">\g<0></span>', code[0])


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


def _linked(page: Path) -> str:
    """A page of experiments/, with its links as they are among the pages of the site."""

    def link(match: re.Match[str]) -> str:
        target = (page.parent / match[1]).resolve()
        if target.name == "README.md":
            return f"]({'index' if target.parent == EXPERIMENTS else target.parent.name}.md"
        return f"](../{target.relative_to(ROOT / 'docs')}" if (ROOT / "docs") in target.parents else match[0]

    text = re.sub(r"\]\((?!https?:|#)([^)#]+)", link, page.read_text("utf-8"))
    return text.replace("](figures/", "](../figures/")


def _stacking(page: str) -> str:
    """A claim's page whose table of values is HTML with labels, so that its columns can stand below each other."""
    before, _, rest = page.partition(BEGIN)
    table, _, after = rest.partition(END)
    head, _, *rows = [_cells(line) for line in table.strip().splitlines()]
    lines = [f"<tr>{''.join(f'<th>{cell}</th>' for cell in head)}</tr>"]
    for row in rows:
        cells = (f'<td data-label="{label}">{cell}</td>' for label, cell in zip(LABELS, row, strict=True))
        lines.append(f"<tr>{''.join(cells)}</tr>")
    return f'{before}<table class="values">{"".join(lines)}</table>\n{after}'


def _cells(line: str) -> list[str]:
    """Cells of a row in Markdown, as HTML."""
    cells = re.split(r"(?<!\\)\|", line.strip())[1:-1]
    return [html.escape(html.unescape(re.sub(r"\\(.)", r"\1", cell.strip()))) for cell in cells]
