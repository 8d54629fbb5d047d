"""Runs a program while Blender waits for it: reads what it says, and stops it."""

import ctypes
import signal
import subprocess
import sys
import threading
import time


class Failure(Exception):
    """What has failed, in words for the user."""


class Result:
    def __init__(self, status, output, cancelled):
        self.status, self.output, self.cancelled = status, output, cancelled


_LIBC = ctypes.CDLL(None) if sys.platform == "linux" else None
_PR_SET_PDEATHSIG = 1  # linux/prctl.h


def _end_with_parent():
    """Has Linux stop the program if Blender is killed."""
    _LIBC.prctl(_PR_SET_PDEATHSIG, signal.SIGTERM)


def start(command, folder, stdin):
    try:
        # In a session of its own it gets no Ctrl-C of a terminal, which would be its second one.
        return subprocess.Popen(
            command, cwd=folder, stdin=stdin, stdout=subprocess.PIPE, stderr=subprocess.PIPE, start_new_session=True,
            preexec_fn=_end_with_parent if _LIBC else None,
        )
    except OSError as error:
        raise Failure(f"{command[0]} cannot be started: {error.strerror}") from None


def run(command, folder, is_cancelled, say, wait=lambda: None):
    """Runs a command in a folder. `say` takes each line of standard error, and `wait` is called between, about ten times a second.

    SIGTERM stops a command that is cancelled: then the program writes its image. Windows has no such signal, and kills it: there, what the
    last checkpoint has written stays.
    """
    process = start(command, folder, subprocess.DEVNULL)
    lines, output = [], []

    def read_lines():
        for line in process.stderr:
            lines.append(line.decode(errors="replace").rstrip())

    readers = [threading.Thread(target=read_lines), threading.Thread(target=lambda: output.append(process.stdout.read()))]
    for reader in readers:
        reader.start()
    cancelled = False
    try:
        while process.poll() is None:
            if not cancelled and is_cancelled():
                cancelled = True
                process.terminate()
            while lines:
                say(lines.pop(0))
            wait()
            time.sleep(0.1)
    finally:
        if process.poll() is None:
            process.kill()
            process.wait()
        for reader in readers:
            reader.join()
        process.stdout.close()
        process.stderr.close()
    while lines:
        say(lines.pop(0))
    return Result(process.returncode, output[0].decode(errors="replace"), cancelled)
