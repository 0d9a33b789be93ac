#!/usr/bin/env python3
"""Runs every command that README.md and docs/ show, taken from the text itself, and compares the output that is shown.

    .ci/doc_commands.py                    all of them
    .ci/doc_commands.py --list             what would be run
    .ci/doc_commands.py README.md WORD     one document, commands that hold a word

Commands are the lines of ```sh blocks, the lines after "$ " in ```text blocks, whose following lines must appear in the
output in this order ("..." stands for anything), and `cargo ...` or `canopy-fem ...` in backticks. A command with a
placeholder in capitals (CASE) or an ellipsis is none. Each document's commands run in one temporary folder, in order.
A command that is too long, or ends with a status of its own, says so in an HTML comment in the text:

    <!-- ci: status 3 "parachute-original" -->          commands in which the regular expression is end with status 3
    <!-- ci: sub "--end 0.5" "--end 0.02" -->           a shorter variant: regular expression and replacement
    <!-- ci: skip "srun" "needs Slurm" -->              not run, and why
    <!-- ci: step "cargo test --release" -->            not run here, but a step of .ci/run, word for word
    <!-- ci: file bad.json                              a file that the commands read
    {...} -->
    <!-- ci: shown flag.json -->                        the ```json block directly below is such a file

Parts of cases (`<!-- ci: part ... -->`) are checked by tests/guide.
"""

import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
# [s] for one command
LIMIT = 900
PLACEHOLDER = re.compile(r"(^|[\s/=])[A-Z][A-Z]+($|[\s/.])")


@dataclass
class Command:
    line: int
    text: str
    # variables and aliases set before it
    setting: list = field(default_factory=list)
    # lines of output that are shown, None where none are
    shown: list | None = None
    # a line of a script, which may use variables in capitals
    script: bool = False


@dataclass
class Document:
    commands: list = field(default_factory=list)
    rules: list = field(default_factory=list)
    files: dict = field(default_factory=dict)


def read(path):
    """Commands, rules and files of a markdown document."""
    found, setting = Document(), []
    text = path.read_text()
    for comment in re.finditer(r"<!-- ci: (.*?)-->", text, re.S):
        head, _, body = comment[1].partition("\n")
        words = shlex.split(head)
        if words[0] == "file":
            found.files[words[1]] = body
        elif words[0] not in ("shown", "part"):
            found.rules.append([*words, 0])
    fence, block, start, above, name = None, [], 0, "", None
    for number, line in enumerate(text.split("\n"), 1):
        if line.startswith("```"):
            if fence is None:
                fence, block, start = line[3:].strip(), [], number + 1
                name = re.fullmatch(r"<!-- ci: shown (\S+) -->", above)
            else:
                if fence == "json" and name:
                    found.files[name[1]] = "\n".join(block) + "\n"
                if fence == "sh":
                    script(found, block, start, setting)
                elif fence == "text":
                    console(found, block, start, setting)
                fence = None
        elif fence is not None:
            block.append(line)
        else:
            for inline in re.findall(r"`((?:cargo|canopy-fem|python3?) [^`]+)`", line):
                found.commands.append(Command(number, inline, list(setting)))
        above = line
    return found


def script(found, block, start, setting):
    """The commands of a shell script: one a line, with what was set before."""
    if block and block[0].startswith("#!"):
        found.commands.append(Command(start, "\n".join(block), list(setting), script=True))
        return
    whole, begun = "", start
    for number, line in enumerate(block, start):
        begun = begun if whole else number
        whole += line
        if whole.endswith("\\"):
            whole = whole[:-1]
            continue
        command, whole = re.sub(r"\s+#.*$", "", whole).strip(), ""
        if re.match(r"(alias \w|\w+=)", command):
            setting.append(command)
        elif command:
            found.commands.append(Command(begun, command, list(setting), script=True))


def console(found, block, start, setting):
    """Commands behind "$ ", each with the output that follows it."""
    last = None
    for number, line in enumerate(block, start):
        if line.startswith("$ "):
            last = Command(number, line[2:].strip(), list(setting), shown=[])
            found.commands.append(last)
        elif last is not None:
            last.shown.append(line)


def decide(command, rules):
    """What is run, with which status; or None and why it is not."""
    text, status = command.text, 0
    for rule in rules:
        kind, words = rule[0], rule[1:-1]
        if kind == "sub":
            changed = re.sub(words[0], words[1], text)
            rule[-1] += changed != text
            text = changed
        elif re.search(words[1 if kind == "status" else 0], command.text):
            if kind == "step" and command.text not in words:
                continue
            rule[-1] += 1
            if kind == "status":
                status = int(words[0])
            elif kind == "skip":
                return None, words[1]
            elif kind == "step":
                if not any(line.strip() == command.text for line in (ROOT / ".ci/run").read_text().split("\n")):
                    return None, "FAULT: no step of .ci/run"
                return None, "a step of its own in .ci/run"
    if "..." in text or (not command.script and PLACEHOLDER.search(text)):
        return None, "no complete command"
    return text, status


def missing(shown, output):
    """The first part of the shown lines that is not in the output where it should be; breaks of lines do not matter."""
    plain = lambda text: " ".join(text.split())
    rest = plain(output)
    for part in "\n".join(shown).split("..."):
        at = rest.find(plain(part))
        if at < 0:
            return part.strip()
        rest = rest[at + len(plain(part)):]
    return None


def folder(where):
    """A folder to run in: the repository's inputs, cargo that finds the project, and canopy-fem as a program."""
    for name in ["assets", "docs", "examples", "benches", "Cargo.toml"]:
        (where / name).symlink_to(ROOT / name)
    shims = where / "bin"
    shims.mkdir()
    cargo = f'sub=$1; shift; exec {subprocess.check_output(["which", "cargo"], text=True).strip()} "$sub" --manifest-path {ROOT}/Cargo.toml "$@"'
    program = f"exec {ROOT}/target/release/canopy-fem \"$@\""
    for name, body in [("cargo", cargo), ("canopy-fem", program)]:
        (shims / name).write_text(f"#!/bin/bash\n{body}\n")
        (shims / name).chmod(0o755)
    return {**os.environ, "PATH": f"{shims}:{ROOT}/target/ci/venv/bin:{os.environ['PATH']}"}


def run(command, text, status, where, env):
    """A command's time [s] and what is wrong with how it ended."""
    whole = "\n".join(["shopt -s expand_aliases", *command.setting, text])
    begun = time.monotonic()
    try:
        ended = subprocess.run(["bash", "-c", whole], cwd=where, env=env, stdin=subprocess.DEVNULL, text=True,
                               stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=LIMIT)
    except subprocess.TimeoutExpired:
        return LIMIT, f"still runs after {LIMIT} s"
    took, wrong = time.monotonic() - begun, None
    if ended.returncode != status:
        wrong = f"status {ended.returncode}, not {status}:\n{ended.stdout[-3000:]}"
    elif command.shown and text == command.text and (part := missing(command.shown, ended.stdout)) is not None:
        wrong = f"the text shows\n{part}\nbut it prints\n{ended.stdout}"
    return took, wrong


def main():
    words = [word for word in sys.argv[1:] if word != "--list"]
    only_list = "--list" in sys.argv
    paths = [ROOT / word for word in words if word.endswith(".md")]
    words = [word for word in words if not word.endswith(".md")]
    faults, count, done = 0, 0, set()
    for path in paths or [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]:
        document = read(path)
        shown = path.relative_to(ROOT)
        with tempfile.TemporaryDirectory() as where:
            env = folder(Path(where))
            for name, body in document.files.items():
                (Path(where) / name).write_text(body)
            for command in document.commands:
                text, what = decide(command, document.rules)
                name = f"{shown}:{command.line}: {(text or command.text).splitlines()[0]}"
                if not all(word in command.text for word in words):
                    continue
                if text in done:
                    text, what = None, "run above"
                if text is None:
                    faults += what.startswith("FAULT")
                    print(f"        -  {name}\n           ({what})", flush=True)
                elif only_list:
                    print(f"           {name}")
                else:
                    # One that does not depend on the folder.
                    if text.startswith("cargo ") and not command.shown:
                        done.add(text)
                    took, wrong = run(command, text, what, where, env)
                    count += 1
                    faults += wrong is not None
                    print(f"{took:7.1f} s  {name}" + (f"\nFAULT: {wrong}" if wrong else ""), flush=True)
        for rule in document.rules:
            if rule[-1] == 0 and not words:
                faults += 1
                print(f"FAULT: {shown}: no command for the rule {rule[:-1]}")
    print(f"{count} commands run, {faults} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
