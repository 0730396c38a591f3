"""Finds and runs the programs of the same installation or build."""

import os
import pathlib
import shutil
import signal
import subprocess
import threading
from typing import Callable, List, Optional, Sequence

from . import errors

_here = pathlib.Path(__file__).parent


def find_program(name: str) -> str:
    """Path of a program such as "tremolo-precompute".

    The first that exists of: the folder in the environment variable TREMOLO_BIN; `bin` in the package (a wheel);
    `bin` of the build or of the installation that the package lies in; PATH.
    """
    given = os.environ.get("TREMOLO_BIN")
    if given:
        path = pathlib.Path(given).absolute() / name
        if not os.access(path, os.X_OK):
            raise errors.FileError(f"{path}: there is no such program, although TREMOLO_BIN names its folder")
        return str(path)
    # As named and as linked: build/python has links to the source tree.
    folders = [_here, *_here.parents]
    for folder in folders[:6]:
        path = folder / "bin" / name
        if path.is_file() and os.access(path, os.X_OK):
            return str(path)
    found = shutil.which(name)
    if found:
        return found
    raise errors.FileError(
        f"{name} was not found beside the package nor on PATH: build it (cmake --build build --target {name}) or set "
        "TREMOLO_BIN to its folder")


def _stop(child: "subprocess.Popen[bytes]") -> None:
    """Ends the child and its processes: SIGTERM, and SIGKILL if that does not help in 5 s."""
    for kind in (signal.SIGTERM, signal.SIGKILL):
        try:
            os.killpg(child.pid, kind)
        except ProcessLookupError:
            pass
        try:
            child.wait(5.0)
            return
        except subprocess.TimeoutExpired:
            pass


def run_program(
    name: str,
    words: Sequence[str],
    *,
    folder: Optional[str] = None,
    on_line: Optional[Callable[[str], None]] = None,
) -> bytes:
    """Runs a program and returns what it printed on stdout; on_line gets each line of stderr.

    If it fails, the exception of its exit code has its message. Any exception here, Ctrl-C too, ends the program.
    """
    lines: List[str] = []
    command = [find_program(name), *words]
    output: List[bytes] = []
    with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          stdin=subprocess.DEVNULL, start_new_session=True) as child:
        assert child.stdout is not None and child.stderr is not None
        stdout = child.stdout
        reader = threading.Thread(target=lambda: output.append(stdout.read()), daemon=True)
        reader.start()
        try:
            for raw in child.stderr:
                line = raw.decode("utf-8", "replace").rstrip("\n")
                lines.append(line)
                if on_line is not None:
                    on_line(line)
            code = child.wait()
        except BaseException:
            _stop(child)
            raise
        reader.join()
    if code == 0:
        return output[0]
    message = next((line for line in reversed(lines) if line.startswith(f"{name}: ")), None)
    message = message[len(name) + 2:] if message else "\n".join(lines[-5:])
    if code < 0:
        message = f"{name} was ended by signal {-code}" + (f": {message}" if message else "")
    raise errors.of_exit_code(code, message)
