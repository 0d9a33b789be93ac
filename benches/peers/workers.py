"""Programs as workers: each is started once for a scene, and answers one line for one run."""

import os
import select
import subprocess
import time

# One thread each, whatever library they call.
SINGLE = dict.fromkeys(["OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS"], "1")


class Lost(Exception):
    """A program that ended or did not answer in time."""


class Worker:
    """A running program; started again after it was lost."""

    def __init__(self, command, log, environment=None):
        self.command, self.log = command, log
        self.environment = os.environ | SINGLE | (environment or {})
        self.process, self.version, self.rest = None, "", b""

    def start(self, limit=120.0):
        """Starts it and waits until it has read the scene."""
        with open(self.log, "ab") as log:
            pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": log}
            # Beside its log, because some write files of their own where they are started.
            folder = os.path.dirname(self.log)
            self.process = subprocess.Popen(self.command, **pipes, env=self.environment, cwd=folder)
        self.rest = b""
        self.version = self.answer("ready", limit)

    def answer(self, wanted, limit):
        """The rest of the next line that begins with one of the wanted words; what else a program prints is dropped."""
        until = time.monotonic() + limit
        while True:
            while b"\n" in self.rest:
                line, self.rest = self.rest.split(b"\n", 1)
                word, _, rest = line.decode(errors="replace").strip().partition(" ")
                if word in wanted.split("|"):
                    return rest if wanted == word else f"{word} {rest}"
            left = until - time.monotonic()
            if left <= 0 or not select.select([self.process.stdout], [], [], left)[0]:
                self.stop()
                raise Lost(f"no answer within {limit:.0f} s")
            more = os.read(self.process.stdout.fileno(), 65536)
            if not more:
                self.stop()
                raise Lost(f"it ended: {self.last_words()}")
            self.rest += more

    def run(self, method, kind, value, file, limit):
        """Makes a run; returns status, seconds, note."""
        if self.process is None:
            self.start()
        self.process.stdin.write(f"{method} {kind} {value!r} {file}\n".encode())
        self.process.stdin.flush()
        status, seconds, *note = self.answer("done|diverged|refused", limit).split(" ", 2)
        return status, float(seconds), note[0] if note else ""

    def last_words(self):
        with open(self.log, encoding="utf-8", errors="replace") as log:
            rows = [row.strip() for row in log if row.strip()]
        return rows[-1][:200] if rows else "without a word"

    def stop(self):
        """Ends it."""
        if self.process is not None:
            self.process.kill()
            self.process.communicate()
            self.process = None
