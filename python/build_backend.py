"""Builds the wheel: the program first, which goes into it as a script, then the module around the same engine.

Hooks of PEP 517: they run in the folder of pyproject.toml, which is that of a checkout or of an unpacked source
distribution.
"""

import json
import shutil
import subprocess
import sys
from pathlib import Path

from maturin import *  # noqa: F403  the other hooks are maturin's
from maturin import build_wheel as build_module

PROGRAM = "canopy-fem.exe" if sys.platform == "win32" else "canopy-fem"

# maturin wants the folder of the program in every hook, also before there is a program.
SCRIPTS = Path.cwd() / "canopy_fem.data" / "scripts"
SCRIPTS.mkdir(parents=True, exist_ok=True)


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """As PEP 517 has it."""
    here = Path.cwd()
    workspace = next(folder for folder in (here, *here.parents) if (folder / "Cargo.lock").exists())
    # Naming the module too gives all crates the features that it needs, so that the engine is compiled once for both.
    packages = ["--package", "canopy-fem", "--package", "canopy-fem-python"]
    build = ["cargo", "build", "--release", *packages, "--bin", "canopy-fem"]
    subprocess.run(build, cwd=workspace, check=True)
    ask = ["cargo", "metadata", "--format-version", "1", "--no-deps"]
    metadata = json.loads(subprocess.run(ask, cwd=workspace, check=True, capture_output=True).stdout)
    shutil.copy2(Path(metadata["target_directory"]) / "release" / PROGRAM, SCRIPTS / PROGRAM)
    # As maturin does with the module: its table of symbols serves no user.
    if strip := shutil.which("strip"):
        subprocess.run([strip, SCRIPTS / PROGRAM], check=True)
    return build_module(wheel_directory, config_settings, metadata_directory)
