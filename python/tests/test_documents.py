"""What documents show runs: the page docs/python.md and the examples."""

import re
import subprocess
import sys
from pathlib import Path

import pytest
from conftest import ROOT

PAGE = ROOT / "docs" / "python.md"
EXAMPLES = sorted((ROOT / "python" / "examples").glob("*.py"))
NEEDS = {"identify_stiffness.py": ["scipy"]}


@pytest.mark.parametrize("example", EXAMPLES, ids=lambda path: path.stem)
def test_examples_run(example, tmp_path):
    for package in NEEDS.get(example.name, []):
        pytest.importorskip(package)
    done = subprocess.run([sys.executable, example], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip()


def test_the_page_runs(tmp_path, monkeypatch):
    """The blocks of the page, one after the other, in one program."""
    for package in ("scipy", "matplotlib", "pandas", "pyvista"):
        pytest.importorskip(package)
    monkeypatch.chdir(tmp_path)
    (tmp_path / "assets").symlink_to(ROOT / "assets")
    monkeypatch.setenv("MPLBACKEND", "Agg")
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), flags=re.DOTALL)
    assert len(blocks) >= 6
    names: dict = {}
    for number, block in enumerate(blocks, 1):
        exec(compile(block, f"{PAGE.name}, block {number}", "exec"), names)


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


def test_the_version_is_that_of_cargo():
    import canopy_fem as cf

    text = (Path(ROOT) / "Cargo.toml").read_text(encoding="utf-8")
    assert f'version = "{cf.__version__}"' in text
