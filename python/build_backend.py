"""Builds the wheel: the program first, which goes into it as a script, then the module around the same engine."""

import shutil
import subprocess
import sys
from pathlib import Path

from maturin import *  # noqa: F403  the other hooks are maturin's
from maturin import build_wheel as build_module

HERE = Path(__file__).resolve().parent
PROGRAM = "canopy-fem.exe" if sys.platform == "win32" else "canopy-fem"


def workspace() -> Path:
    """The folder with Cargo.lock: that of a checkout, or that of an unpacked source distribution."""
    return next(folder for folder in (HERE, *HERE.parents) if (folder / "Cargo.lock").exists())


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    """As PEP 517 has it."""
    root = workspace()
    build = ["cargo", "build", "--release", "--locked", "--package", "canopy-fem", "--bin", "canopy-fem"]
    subprocess.run([*build, "--message-format", "short"], cwd=root, check=True)
    metadata = subprocess.run(
        ["cargo", "metadata", "--format-version", "1", "--no-deps"], cwd=root, check=True, capture_output=True
    )
    import json

    target = Path(json.loads(metadata.stdout)["target_directory"])
    scripts = HERE / "canopy_fem.data" / "scripts"
    scripts.mkdir(parents=True, exist_ok=True)
    shutil.copy2(target / "release" / PROGRAM, scripts / PROGRAM)
    return build_module(wheel_directory, config_settings, metadata_directory)
