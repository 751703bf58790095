"""Pages of the claims: each has its title, its table of values, and a row in the table of verdicts."""

import json

import pytest

from experiments import pages
from experiments.registry import REGISTRY
from jointattn_mj.errors import OutputError
from jointattn_mj.sweeps.claim import Verdict

README = pages.HERE / "README.md"
FINDING = {
    "what": "heads | tails",
    "dissertation": "half",
    "here": "51% [40%, 60%]",
    "n": 9,
    "verdict": "partly",
    "note": "",
}


@pytest.mark.parametrize("claim_id", REGISTRY)
def test_a_claim_has_a_page(claim_id):
    page = pages.page_of(claim_id).read_text("utf-8")
    assert page.startswith(f"# {claim_id}: {REGISTRY.entries[claim_id].title}\n")
    assert f"jointattn experiment run {claim_id} --out" in page
    assert pages.verdicts(page)


def test_the_table_of_verdicts_is_that_of_the_pages():
    assert pages.index() in README.read_text("utf-8")


def test_values_of_a_report_go_into_the_page():
    page = pages.with_values(pages.page_of("4.7").read_text("utf-8"), [FINDING, {**FINDING, "note": "a | b"}])
    assert r"| heads \| tails | half | 51% [40%, 60%] | 9 | partly: a \| b |" in page
    assert pages.verdicts(page) == [Verdict.PARTLY, Verdict.PARTLY]
    assert page.count(pages.BEGIN) == page.count(pages.END) == 1


def test_only_what_was_run_is_written(tmp_path, monkeypatch):
    """With the pages in another folder."""
    for page in [README, *map(pages.page_of, REGISTRY)]:
        copy = tmp_path / page.relative_to(pages.HERE)
        copy.parent.mkdir(exist_ok=True)
        copy.write_text(page.read_text("utf-8"), "utf-8")
    monkeypatch.setattr(pages, "HERE", tmp_path)
    claims = [{"id": "4.7", "findings": [FINDING]}, {"id": "5.2", "findings": []}]
    (tmp_path / "claims.json").write_text(json.dumps(claims))
    before = pages.page_of("5.2").read_text("utf-8")
    pages.main(tmp_path)
    assert "51% [40%, 60%]" in pages.page_of("4.7").read_text("utf-8")
    assert pages.page_of("5.2").read_text("utf-8") == before
    assert "chance](experience/README.md) | partly |" in (tmp_path / "README.md").read_text("utf-8")


def test_no_report(tmp_path):
    with pytest.raises(OutputError, match="run `jointattn experiment report"):
        pages.main(tmp_path)
