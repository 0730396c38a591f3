"""Finds the programs of Tremolo, starts them in the background and reads what they print.

Nothing here needs Blender. A job is a generator: it yields (fraction, text) while the work goes on
and ends with StopIteration, or with Refused, whose text is the program's own message.
"""
import collections
import os
import queue
import shutil
import signal
import subprocess
import threading
import time

kWait = 0.01  # s between two looks at a program that runs
kReport = 1.0  # s between two lines of progress
kGrace = 2.0  # s that a program has to end by itself after a signal

# Part of a precompute that is done when a stage has printed its line, and the work that follows. Fractions were
# measured on a ball of 20 000 triangles and on a small one; the order is that of tremolo-precompute.
kStages = {'': (0.0, 'making tetrahedra'), 'mesh': (0.08, 'stiffness and mass'),
           'matrices': (0.12, 'vibrations'), 'modes': (0.45, 'how they bend each other'),
           'derivatives': (0.62, 'checking the vibrations'), 'certificate': (0.75, 'choosing shapes'),
           'basis': (0.80, 'choosing shapes'), 'inertia': (0.81, 'forces'), 'coefficients': (0.98, 'writing'),
           'file': (1.0, 'done')}


class Refused(Exception):
    """The work cannot be done; the text is for the user."""


def find_program(name, folder=''):
    """The path of a program: in `folder`, in $TREMOLO_PROGRAMS, or in the PATH. Raises Refused."""
    if os.name == 'nt':
        name += '.exe'
    for place in (folder, os.environ.get('TREMOLO_PROGRAMS', '')):
        path = os.path.join(os.path.expanduser(place), name) if place else ''
        if path and os.access(path, os.X_OK) and os.path.isfile(path):
            return path
    path = shutil.which(name)
    if path:
        return path
    where = f' in {folder}' if folder else ''
    raise Refused(f'{name} was not found{where}: set the folder of the programs in '
                  'Edit > Preferences > Add-ons > Tremolo')


class Program:
    """A program that runs. Its lines are read by threads, so that its pipes never fill."""

    def __init__(self, command, folder):
        options = {}
        if os.name == 'nt':
            options['creationflags'] = subprocess.CREATE_NEW_PROCESS_GROUP
        else:
            options['start_new_session'] = True  # its mesher ends with it
        # Blender's own Python must not be that of programs which a program may start.
        environment = {k: v for k, v in os.environ.items() if k not in ('PYTHONHOME', 'PYTHONPATH')}
        environment.update(OMPI_ALLOW_RUN_AS_ROOT='1', OMPI_ALLOW_RUN_AS_ROOT_CONFIRM='1')
        try:
            self.process = subprocess.Popen(command, cwd=folder, env=environment, text=True, errors='replace',
                                            stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                            stderr=subprocess.PIPE, **options)
        except OSError as error:
            raise Refused(f'{command[0]} cannot be started: {error.strerror}') from error
        self.name = os.path.basename(command[0])
        self.lines = queue.Queue()
        self.errors = collections.deque(maxlen=400)
        self.output = []
        self.readers = [threading.Thread(target=self._read, args=(self.process.stderr, True), daemon=True),
                        threading.Thread(target=self._read, args=(self.process.stdout, False), daemon=True)]
        for reader in self.readers:
            reader.start()

    def _read(self, stream, is_log):
        with stream:
            for line in stream:
                if is_log:
                    self.errors.append(line.rstrip())
                    self.lines.put(line.rstrip())
                else:
                    self.output.append(line)

    def stop(self):
        """Ends the program and everything that it has started."""
        for number in ('SIGTERM', 'SIGKILL'):
            if self.process.poll() is not None:
                break
            try:
                if os.name == 'nt':
                    self.process.terminate()
                else:
                    os.killpg(self.process.pid, getattr(signal, number))
            except ProcessLookupError:
                pass
            try:
                self.process.wait(kGrace)
            except subprocess.TimeoutExpired:
                pass
        self._join()

    def _join(self):
        for reader in self.readers:
            reader.join(kGrace)

    def finished(self):
        """Whether it has ended; all of its lines have then been read."""
        if self.process.poll() is None:
            return False
        self._join()
        return True

    def message(self):
        """The error of the program: from the last line that begins with a program's name on."""
        lines = [line for line in self.errors if line]
        starts = [i for i, line in enumerate(lines) if line.startswith('tremolo')]
        words = lines[starts[-1]:] if starts else lines[-3:]
        code = self.process.returncode
        ended = f'signal {-code}' if code < 0 else f'exit code {code}'
        return '\n'.join(words) if words else f'{self.name} ended with {ended} and no message'

    def warnings(self):
        """Texts after "warning:"; those of CGAL are for programmers."""
        return [line.split('warning:', 1)[1].strip() for line in self.errors
                if 'warning:' in line and not line.startswith('CGAL')]


def run(command, folder, stages=None):
    """Job: runs a program to its end; its value is the Program. stages: as kStages."""
    program = Program(command, folder)
    fraction, text = stages[''] if stages else (0.0, program.name)
    try:
        while True:
            ended = program.finished()
            while not program.lines.empty():
                line = program.lines.get()
                words = line.split()
                if stages and words and words[0] in stages:
                    fraction, text = stages[words[0]]
                elif words and not stages:
                    text = line.strip()
            if ended:
                break
            yield fraction, text
            time.sleep(0 if not program.lines.empty() else kWait)
    finally:
        if program.process.poll() is None:
            program.stop()
    if program.process.returncode != 0:
        raise Refused(program.message())
    return program


def wait_for(job, report=None):
    """Runs a job to its end in this thread; returns its value. report(fraction, text): new progress."""
    last, due = None, time.monotonic() + kReport
    try:
        while True:
            step = next(job)
            if report and step != last and time.monotonic() >= due:
                report(*step)
                last, due = step, time.monotonic() + kReport
    except StopIteration as end:
        return end.value
    finally:
        job.close()
