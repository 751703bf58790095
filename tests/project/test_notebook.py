"""The notebook: committed as it was executed, and its code still runs."""

from pathlib import Path

import matplotlib
import pytest

pytestmark = pytest.mark.integration

PATH = Path(__file__).parents[2] / "docs" / "joint_attention.ipynb"
nbformat = pytest.importorskip("nbformat", reason="the extra notebook brings it")


@pytest.fixture
def notebook():
    return nbformat.read(PATH, as_version=4)


def test_it_is_committed_as_executed(notebook):
    nbformat.validate(notebook)
    cells = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in cells] == list(range(1, len(cells) + 1))
    outputs = [output for cell in cells for output in cell.outputs]
    assert {output.output_type for output in outputs} <= {"stream", "display_data", "execute_result"}
    assert sum("image/png" in output.get("data", {}) for output in outputs) == 4
    assert not any(output.get("name") == "stderr" for output in outputs)


def test_its_code_runs(notebook):
    """In this process; the cell that installs the package is for Colab."""
    before = matplotlib.get_backend()
    matplotlib.use("Agg")
    namespace: dict = {}
    for cell in notebook.cells[2:]:
        if cell.cell_type == "code":
            exec(compile(cell.source, cell.id, "exec"), namespace)
    matplotlib.use(before)
    names = [module.name for module in namespace["development"].modules]
    assert names[:3] == ["FG-m", "SCf-m", "SC-m"]
    assert namespace["summary"].late_success_rate > 0.6


@pytest.mark.slow
def test_it_runs_in_jupyter(notebook, tmp_path):
    from nbclient import NotebookClient

    NotebookClient(notebook, timeout=600, kernel_name="python3", resources={"metadata": {"path": tmp_path}}).execute()
