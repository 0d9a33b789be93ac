"""What documents show runs: the page docs/python.md and the notebooks."""

import re
from pathlib import Path

import pytest
from conftest import ROOT

GUIDE = ROOT / "docs" / "guide" / "src"
PAGES = [ROOT / "docs" / "python.md", GUIDE / "python.md", GUIDE / "coupling.md", GUIDE / "flow.md"]
NOTEBOOKS = sorted((ROOT / "python" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebooks_run(path):
    """Each notebook runs where it lies, from top to bottom, and what it shows in the repository is of such a run."""
    nbformat, nbclient = pytest.importorskip("nbformat"), pytest.importorskip("nbclient")
    for package in ("ipykernel", "matplotlib", "scipy"):
        pytest.importorskip(package)
    notebook = nbformat.read(path, as_version=4)
    code = [cell for cell in notebook.cells if cell.cell_type == "code"]
    assert [cell.execution_count for cell in code] == list(range(1, len(code) + 1))
    assert path.stat().st_size < 200_000
    nbclient.NotebookClient(notebook, timeout=300, resources={"metadata": {"path": str(path.parent)}}).execute()


@pytest.mark.parametrize("page", PAGES, ids=["reference", "guide", "coupling", "flow"])
def test_pages_run(page, tmp_path, monkeypatch):
    """The blocks of a page, one after the other, in one program."""
    for package in ("scipy", "matplotlib", "pandas", "pyvista"):
        pytest.importorskip(package)
    monkeypatch.chdir(tmp_path)
    for folder in ("assets", "examples", "docs"):
        (tmp_path / folder).symlink_to(ROOT / folder)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    blocks = re.findall(r"```python\n(.*?)```", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert blocks
    names: dict = {}
    for number, block in enumerate(blocks, 1):
        exec(compile(block, f"{page.name}, block {number}", "exec"), names)


def test_every_public_name_has_a_docstring():
    import canopy_fem as cf

    for name in cf.__all__:
        thing = getattr(cf, name)
        if name.startswith("__"):
            continue
        assert thing.__doc__, name
        for member, value in vars(thing).items() if isinstance(thing, type) else []:
            if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                assert value.__doc__, f"{name}.{member}"


def test_the_wheel_has_its_licence_and_names_its_authors():
    """The module's folder has a copy of the project's licence, since a wheel takes none from above."""
    from importlib import metadata

    assert (ROOT / "python" / "LICENSE.txt").read_text() == (ROOT / "LICENSE").read_text()
    told = metadata.metadata("canopy-fem")
    assert told["License-Expression"] == "MIT" and told["Author"] == "The canopy-fem developers"
    files = metadata.files("canopy-fem") or []
    assert any(file.name == "LICENSE.txt" for file in files)


def test_the_version_is_that_of_cargo():
    import canopy_fem as cf

    text = (Path(ROOT) / "Cargo.toml").read_text(encoding="utf-8")
    assert f'version = "{cf.__version__}"' in text
