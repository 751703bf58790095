"""The site of the documentation: built without a warning, and whole when it is opened as a file without network."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.integration

ROOT = Path(__file__).parents[2]
pytest.importorskip("material", reason="the extra docs brings it")


@pytest.fixture(scope="module")
def site(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    build = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    done = subprocess.run(build, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return folder


def test_pages_load_nothing_from_elsewhere(site):
    pages = list(site.rglob("*.html"))
    assert site / "index.html" in pages
    for page in pages:
        loaded = re.findall(r'<(?:script|img|iframe)\b[^>]*\bsrc="([^"]*)"', page.read_text("utf-8"))
        loaded += re.findall(
            r'<link\b[^>]*\brel="(?:stylesheet|preload|icon)"[^>]*\bhref="([^"]*)"', page.read_text("utf-8")
        )
        assert loaded
        assert not [address for address in loaded if re.match(r"(\w+:)?//", address)], page


def test_options_are_not_broken_after_their_dashes(site):
    page = (site / "at-your-table.html").read_text("utf-8")
    assert '<code><span class="option">--fov-deg</span> 110</code>' in page
    assert not re.findall(r"<code>--\w", page)
    assert ".option { white-space: nowrap" in (site / "stylesheets" / "site.css").read_text("utf-8")


def test_search_finds_something_in_a_page_opened_as_a_file(site, tmp_path):
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    if browser is None:
        pytest.skip("needs Chromium")

    def found(word: str) -> int:
        command = [browser, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path}", "--dump-dom"]
        address = f"{(site / 'index.html').as_uri()}?q={word}"
        done = subprocess.run(
            [*command, "--virtual-time-budget=20000", address], capture_output=True, text=True, timeout=120
        )
        said = re.search(r'md-search-result__meta">\s*([^<]*)<', done.stdout)
        assert said, done.stdout
        return int(re.match(r"\d+|No", said[1])[0].replace("No", "0"))

    assert found("habituation") >= 1
    assert found("zzyzx") == 0
