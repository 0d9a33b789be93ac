"""The program ``canopy-fem``, as a command and as ``python -m canopy_fem``: its engine is that of the module."""

import os
import signal
import sys


def main() -> int:
    """Runs the program with the arguments of this process, and returns its exit status."""
    # Until the program catches Ctrl-C, it ends the process without a traceback. One that is ignored stays so.
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
    _open_streams()
    from ._core import _program

    return _program(sys.argv[1:])


def _open_streams() -> None:
    """Opens standard streams that are closed, as Rust does: a result must not get the number of one."""
    for number in range(3) if os.name == "posix" else ():
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)


if __name__ == "__main__":
    sys.exit(main())
