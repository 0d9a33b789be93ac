"""Makes everything ready in target/peers: a virtual environment, the programs in C++ and Rust, canopy-fem. What fails
is written down with its reason in target/peers/missing.json, and the others run. Standard library only."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent.parent
TARGET = ROOT / "target" / "peers"
PYTHON = TARGET / "venv" / "bin" / "python"
MISSING = TARGET / "missing.json"
OURS, PROGRAM = "peer_canopy_fem", "canopy-fem"
CXX = ["-O3", "-march=native", "-ffast-math", "-fno-finite-math-only", "-std=c++17"]  # a NaN must stay one
RUST_FLAGS = "-C target-cpu=native"  # as -march=native
# What no registry serves, and why it is not run.
UNSERVED = {
    "particle-system-simulator": "PyPI has no package of it, only a repository",
    "ppf-contact-solver": "neither PyPI nor crates.io has a package of it, only a repository",
}
# Debian's packages that are taken to pieces under target/peers where the system has them not, without being installed.
DEBS = {"eigen3": "libeigen3-dev", "sundials": "libsundials-dev"}
SUNDIALS = ["libsundials_arkode", "libsundials_cvode", "libsundials_nvecserial"]


class Failed(Exception):
    """A step that could not be made; the message is for the table."""


def call(command, **more):
    """Runs a command; its first line of complaint is the reason if it fails."""
    try:
        done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, **more)
    except OSError as why:
        raise Failed(f"{command[0]}: {why.strerror}") from why
    if done.returncode != 0:
        rows = [row.strip() for row in (done.stderr or done.stdout).splitlines() if row.strip()]
        complaint = [row for row in rows if "rror" in row] or rows[-1:] or ["failed without a word"]
        raise Failed(f"{Path(str(command[0])).name}: {complaint[0]}")
    return done.stdout


def say(what):
    print(f"  {what}", file=sys.stderr, flush=True)


def environment():
    """The virtual environment; requirements one by one, so that one without a wheel here does not take others along."""
    rows = [row for row in (HERE / "requirements.txt").read_text().splitlines() if row.strip()]
    stamp, key = TARGET / "venv" / "stamp.json", hashlib.sha256("\n".join(rows).encode()).hexdigest()
    if stamp.exists() and (known := json.loads(stamp.read_text()))["key"] == key:
        return known["missing"]
    say("virtual environment: a minute or two, once")
    missing = {}
    call([sys.executable, "-m", "venv", TARGET / "venv"])
    for row in rows:
        name = row.split("==")[0]
        try:
            call([PYTHON, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", row])
        except Failed as why:
            missing[name] = str(why)
            say(f"{name}: {why}")
    stamp.write_text(json.dumps({"key": key, "missing": missing}))
    return missing


def headers(name):
    """Folders that hold include/ and lib/ of a C++ library: the system's, or a Debian package taken to pieces."""
    marker = {"eigen3": "eigen3/Eigen/SparseCholesky", "sundials": "arkode/arkode_erkstep.h"}[name]
    for prefix in (Path("/usr"), Path("/usr/local"), TARGET / "debs" / "usr"):
        if (prefix / "include" / marker).exists():
            return prefix
    package = DEBS[name]
    if not (shutil.which("apt-get") and shutil.which("dpkg")):
        raise Failed(f"install {package} (or your system's name of it)")
    say(f"{package}: fetched, not installed")
    folder = TARGET / "debs"
    folder.mkdir(parents=True, exist_ok=True)
    try:
        call(["apt-get", "download", package], cwd=folder)
        for file in folder.glob(f"{package}_*.deb"):
            call(["dpkg", "-x", file, folder])
    except Failed as why:
        raise Failed(f"install {package}, or run apt-get update so that it can be fetched ({why})") from why
    return folder / "usr"


def compile_cpp(name):
    """Compiles NAME.cpp into target/peers if it is older than its sources."""
    program, source = TARGET / name, HERE / f"{name}.cpp"
    flags, libraries = list(CXX), []
    if name != "plain_cpp":
        flags += ["-isystem", headers("eigen3") / "include" / "eigen3"]
    if name == "plain_sundials":
        prefix = headers("sundials")
        flags += ["-isystem", prefix / "include"]
        for library in SUNDIALS:
            found = sorted(prefix.glob(f"lib/**/{library}.a")) + sorted(prefix.glob(f"lib/**/{library}.so"))
            if not found:
                raise Failed(f"{library} was not found beside its headers")
            libraries.append(found[0])
    newest = max(file.stat().st_mtime for file in [source, *HERE.glob("*.hpp")])
    if not program.exists() or program.stat().st_mtime < newest:
        say(f"{name}.cpp")
        call([os.environ.get("CXX", "g++"), *flags, source, *libraries, "-o", program])


def compile_rust(name):
    """Compiles the crate in the folder NAME, of the versions in its Cargo.lock, into target/peers."""
    say(f"{name} (cargo build --release)")
    flags = {"RUSTFLAGS": RUST_FLAGS, "CARGO_TARGET_DIR": str(TARGET / "rust")}
    call(["cargo", "build", "--release", "--locked"], cwd=HERE / name, env=os.environ | flags)
    shutil.copy2(TARGET / "rust" / "release" / name, TARGET / name)


def build_ours():
    """canopy-fem, as anybody builds it."""
    say("canopy-fem (cargo build --release)")
    folder = ROOT / os.environ.get("CARGO_TARGET_DIR", "target") / "release"
    for package, program in (("canopy-fem", PROGRAM), ("canopy-fem-benches", OURS)):
        call(["cargo", "build", "--release", "--package", package, "--bin", program], cwd=ROOT)
        shutil.copy2(folder / program, TARGET / program)


def prepare():
    """All of it; writes down what is missing and why."""
    TARGET.mkdir(parents=True, exist_ok=True)
    missing = dict(UNSERVED)
    steps = {"environment": environment, OURS: build_ours}
    steps |= {name: lambda name=name: compile_cpp(name) for name in ("plain_cpp", "plain_eigen", "plain_sundials")}
    steps["rapier_cloth"] = lambda: compile_rust("rapier_cloth")
    for name, step in steps.items():
        try:
            missing |= step() or {}
        except Failed as why:
            missing[name] = str(why)
            say(f"{name}: {why}")
    MISSING.write_text(json.dumps(missing, indent=2))
    for vital in (OURS, "environment", "numpy"):
        if vital in missing:
            sys.exit(f"nothing can be compared without {vital}: {missing[vital]}")
