"""The program as a user starts it: the command, and the module; its engine is that of the module."""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from conftest import CASES, cloth

import canopy_fem as cf

MODULE = [sys.executable, "-m", "canopy_fem"]
ON_UNIX = pytest.mark.skipif(os.name == "nt", reason="needs signals, or files that Windows lacks")


def ended(*arguments, **options):
    command = [*MODULE, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, encoding="utf-8", **options)


@pytest.fixture
def case_file(tmp_path):
    path = tmp_path / "square.json"
    path.write_text(json.dumps(cloth()))
    return path


@pytest.mark.parametrize("start", [MODULE, [cf.program()]], ids=["module", "command"])
def test_status_and_streams_are_those_of_the_program(start, case_file, tmp_path):
    """What is printed and the exit status: 0, 2 for a bad call or case, 3 for a run that diverges."""

    def run(*arguments):
        done = subprocess.run([*start, *map(str, arguments)], capture_output=True, text=True, encoding="utf-8")
        return done.returncode, done.stdout, done.stderr

    status, out, told = run("--version")
    assert status == 0 and out.startswith(f"canopy-fem {cf.__version__}") and told == ""
    status, out, told = run("sovle", case_file)
    assert status == 2 and out == "" and "solve" in told and "Usage: canopy-fem" in told
    status, out, told = run("solve", case_file, "--set", "time.step=-1", "--out", tmp_path / "out")
    assert status == 2 and told.startswith("error: ") and "time.step" in told or "/time/step" in told
    status, out, told = run("solve", case_file, "--set", "time.step=0.05", "--end", "10", "--out", tmp_path / "far")
    assert status == 3 and "diverged" in out + told
    assert run("solve", case_file, "--out", tmp_path / "near", "--quiet") == (0, "", "")


def test_the_program_starts_without_numpy():
    """Neither the module of the program nor the engine imports it: a start takes no longer than they do."""
    told = subprocess.run(
        [sys.executable, "-X", "importtime", *MODULE[1:], "--version"], capture_output=True, text=True, check=True
    ).stderr
    imported = {line.rsplit("|", 1)[1].strip() for line in told.splitlines() if "|" in line}
    assert {"canopy_fem", "canopy_fem._core"} <= imported
    assert not imported & {"numpy", "typing", "subprocess", "canopy_fem.public"}


def test_public_names_are_there_when_they_are_asked_for():
    """A name is found, listed and starred, and one that is not there is an error of the module."""
    program = (
        "import sys, canopy_fem as cf; assert 'numpy' not in sys.modules; "
        "assert set(cf.__all__) <= set(dir(cf)); from canopy_fem import *; assert Case is cf.Case and mesh is cf.mesh"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
    with pytest.raises(AttributeError, match="'canopy_fem' has no attribute 'Sail'"):
        _ = cf.Sail  # type: ignore[attr-defined]


@ON_UNIX
def test_closed_and_full_outputs(case_file, tmp_path):
    """A closed pipe is no failure, a full disk is one, and no result gets what a closed standard output would."""
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([*MODULE, "methods"], stdout=writer, stderr=subprocess.PIPE)
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, b"")
    if os.path.exists("/dev/full"):
        with open("/dev/full", "wb") as full:
            done = subprocess.run([*MODULE, "methods"], stdout=full, stderr=subprocess.PIPE)
        assert done.returncode == 1 and done.stderr.startswith(b"error: standard output: ")
    for name, closed in (("open", ""), ("closed", "<&- >&- 2>&-")):
        command = f'exec "$@" {closed}'
        subprocess.run(
            ["sh", "-c", command, "sh", *MODULE, "solve", case_file, "--out", tmp_path / name],
            check=True,
            capture_output=True,
        )
    for table in ("history.csv", "probes.csv"):
        assert (tmp_path / "open" / table).read_bytes() == (tmp_path / "closed" / table).read_bytes()


@ON_UNIX
def test_a_file_beyond_the_limit_is_told(case_file, tmp_path):
    """A write beyond the largest size of files fails with a message, and does not end the process without one."""
    limited = ["sh", "-c", 'ulimit -f 4; exec "$@"', "sh", *MODULE]
    done = subprocess.run([*limited, "solve", case_file, "--out", tmp_path / "out"], capture_output=True, text=True)
    assert done.returncode == 1 and done.stderr.startswith("error:") and "File too large" in done.stderr


def test_colours_are_asked_for():
    """`CLICOLOR_FORCE` colours what goes to a pipe; nothing else does."""
    plain = ended("solve", "missing.json")
    coloured = ended("solve", "missing.json", env=os.environ | {"CLICOLOR_FORCE": "1"})
    assert "\x1b" not in plain.stderr and "\x1b[" in coloured.stderr and plain.returncode == coloured.returncode == 2


@ON_UNIX
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_ends_a_run_with_its_checkpoint(name, tmp_path):
    """The run saves what it has, and the status is 130: the interpreter raises nothing."""
    out = tmp_path / "out"
    command = [*MODULE, "solve", CASES / "cloth-k1000.json", "--set", "time.end=2000", "--out", out]
    with subprocess.Popen(command, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as process:
        while not (out / "history.csv").exists():
            assert process.poll() is None, process.communicate()
            time.sleep(0.02)
        process.send_signal(getattr(signal, name))
        printed, told = process.communicate(timeout=60)
    assert process.returncode == 130 and "Traceback" not in told
    assert (out / "checkpoint.bin").exists() and "interrupted" in printed


@ON_UNIX
def test_names_that_are_no_text_reach_the_program(case_file, tmp_path):
    """Bytes of an argument that are not UTF-8 are those of the file."""
    if sys.platform == "darwin":
        pytest.skip("its file system has no such names")
    odd = os.path.join(os.fsencode(tmp_path), b"caf\xe9.json")
    os.rename(case_file, odd)
    done = subprocess.run([*MODULE, "solve", odd, "--out", tmp_path / "out", "--quiet"], capture_output=True)
    assert (done.returncode, done.stderr) == (0, b"")


def test_a_study_is_of_this_package_in_any_folder(small, tmp_path, monkeypatch):
    """Modules that lie in the working folder are not imported, and reports tell the command of the program."""
    for name in ("signal", "numpy", "canopy_fem"):
        (tmp_path / f"{name}.py").write_text("raise RuntimeError('not this one')\n")
    monkeypatch.chdir(tmp_path)
    cf.sweep(small, {"time.step": [1e-3, 5e-4]}, "steps")
    report = json.loads((tmp_path / "steps" / "sweep.json").read_text())
    assert report["command"].startswith("canopy-fem sweep ")


def test_messages_of_a_study_have_no_colours_and_breaks(small, monkeypatch):
    """A terminal's width and colours that the environment asks for are not for exceptions."""
    monkeypatch.setenv("COLUMNS", "40")
    monkeypatch.setenv("CLICOLOR_FORCE", "1")
    with pytest.raises(cf.CaseError) as caught:
        cf.sweep(small, {"system.network.springs.0.stiffness": [-1.0]})
    message = str(caught.value)
    assert "\x1b" not in message and not message.startswith("error") and max(map(len, message.splitlines())) > 40
