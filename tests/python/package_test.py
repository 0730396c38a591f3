"""The package as a whole: types, documentation, installation, what it links."""

import ast
import os
import re
import subprocess
import sys
import tempfile
import unittest

import support
import tremolo
from tremolo import _tremolo

PYTHON_DIR = os.path.join(support.SOURCE, "runtime", "apps", "python")


def run(*command, **options):
    """Runs a command; its output is part of the failure."""
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **options)
    if done.returncode != 0:
        raise AssertionError(f"{' '.join(command)}\n{done.stdout}")
    return done.stdout


def has_mypy():
    return subprocess.run([sys.executable, "-m", "mypy", "--version"], capture_output=True, check=False).returncode == 0


@unittest.skipUnless(has_mypy(), "mypy is not installed")
class Types(unittest.TestCase):
    def test_of_the_package_are_consistent(self):
        run(sys.executable, "-m", "mypy", "--strict",
            "--cache-dir", os.path.join(support.folder(), "mypy"), os.path.join(PYTHON_DIR, "tremolo"))

    def test_are_those_of_the_compiled_module(self):
        # Every name of either is in the other.
        environment = {**os.environ, "MYPYPATH": PYTHON_DIR, "MYPY_CACHE_DIR": os.path.join(support.folder(), "mypy")}
        run(sys.executable, "-m", "mypy.stubtest", "--ignore-missing-stub", "--allowlist",
            os.path.join(support.SOURCE, "tests", "python", "stub_exceptions.txt"), "tremolo._tremolo",
            env=environment, cwd=support.folder())

    def test_have_the_arguments_of_the_compiled_module(self):
        # Its functions have their signature in the first line of the docstring.
        with open(os.path.join(PYTHON_DIR, "tremolo", "_tremolo.pyi"), encoding="utf-8") as file:
            stub = ast.parse(file.read())
        compared = 0
        scopes = [(_tremolo, stub.body)]
        scopes += [(getattr(_tremolo, node.name), node.body) for node in stub.body if isinstance(node, ast.ClassDef)]
        for owner, body in scopes:
            for node in body:
                if not isinstance(node, ast.FunctionDef) or node.decorator_list or node.name.startswith("_"):
                    continue
                doc = getattr(owner, node.name).__doc__.splitlines()[0]
                found = re.findall(r"(?:^|, )(\w+): ", re.match(r"\w+\((.*)\) -> ", doc)[1])
                stated = [arg.arg for arg in node.args.args + node.args.kwonlyargs if arg.arg != "self"]
                self.assertEqual([name for name in found if name != "self"], stated, doc)
                compared += 1
        self.assertGreater(compared, 60)

    def test_find_wrong_calls_of_a_user(self):
        program = os.path.join(support.folder(), "wrong.py")
        with open(program, "w", encoding="utf-8") as file:
            file.write("import tremolo\nmodel = tremolo.load('a')\nbody = model.body(step='long')\nbody.stepp()\n"
                       "body.q[0] = 1.0\nx: str = body.time\n")
        done = subprocess.run([sys.executable, "-m", "mypy", "--cache-dir", os.path.join(support.folder(), "mypy"),
                               program], capture_output=True, text=True, check=False,
                              env={**os.environ, "MYPYPATH": PYTHON_DIR})
        lines = set(re.findall(r"wrong\.py:(\d+): error", done.stdout))
        self.assertEqual(lines, {"3", "4", "6"}, done.stdout)


class Documentation(unittest.TestCase):
    def test_page_is_that_of_the_docstrings(self):
        path = os.path.join(support.folder(), "python.md")
        run(sys.executable, os.path.join(PYTHON_DIR, "page", "make_page.py"), path)
        with open(path, encoding="utf-8") as made, \
                open(os.path.join(support.SOURCE, "docs", "python.md"), encoding="utf-8") as kept:
            self.assertEqual(made.read(), kept.read(), "docs/python.md is old: make_page.py writes it")

    def test_is_there_for_every_name(self):
        for name in tremolo.__all__:
            thing = getattr(tremolo, name)
            if name != "__version__":
                self.assertTrue(thing.__doc__, name)
        for kind in (tremolo.Model, tremolo.Body, tremolo.World, tremolo.NodalBody, tremolo.NodalScene,
                     tremolo.OwnBody, tremolo.Recorder):
            for key, member in vars(kind).items():
                if not key.startswith("_"):
                    self.assertTrue(member.__doc__, f"{kind.__name__}.{key}")

    def test_first_program_of_the_page_runs(self):
        with open(os.path.join(PYTHON_DIR, "page", "page.md"), encoding="utf-8") as file:
            program = re.search(r"```python\n(.*?)```", file.read(), re.S)[1]
        self.assertRegex(run(sys.executable, "-c", program), r"^[0-9.e-]+ \(\d+, 3\)\n$")


class Linking(unittest.TestCase):
    def test_needs_no_solver_no_mpi_and_no_mesher(self):
        needed = run("ldd", _tremolo.__file__)
        for library in ("petsc", "slepc", "mpi", "metis", "cholmod", "blas", "CGAL", "assimp"):
            self.assertNotRegex(needed, f"(?i)lib{library}")

    def test_exports_its_initialisation_alone(self):
        names = re.findall(r" [TWBDVu] (\S+)", run("nm", "-D", "--defined-only", _tremolo.__file__))
        self.assertEqual([name for name in names if not name.startswith("_ZTS") and "tremolo" in name],
                         ["PyInit__tremolo"])


class Installation(unittest.TestCase):
    def test_by_cmake_finds_its_programs(self):
        build = os.environ.get("TREMOLO_BUILD_DIR")
        if not build:
            self.skipTest("TREMOLO_BUILD_DIR is not set")
        with tempfile.TemporaryDirectory() as prefix:
            for component in ("python", "programs"):
                run("cmake", "--install", build, "--prefix", prefix, "--component", component)
            package, = [os.path.join(top) for top, folders, _ in os.walk(prefix) if "tremolo" in folders and
                        top.endswith("-packages")]
            program = "import tremolo; print(tremolo.__file__); print(tremolo.find_program('tremolo-precompute'))"
            environment = {**os.environ, "PYTHONPATH": package}
            lines = run(sys.executable, "-c", program, env=environment, cwd="/").split()
            self.assertTrue(lines[0].startswith(prefix))
            self.assertEqual(lines[1], os.path.join(prefix, "bin", "tremolo-precompute"))

    def test_of_a_wheel_in_a_clean_environment(self):
        build = os.environ.get("TREMOLO_BUILD_DIR")
        if not build:
            self.skipTest("TREMOLO_BUILD_DIR is not set")
        try:
            import venv
            import ensurepip
        except ImportError:
            self.skipTest("python3-venv is not installed")
        del ensurepip
        with tempfile.TemporaryDirectory() as folder:
            # As `pip install .` does, without a network, from the build that exists.
            wheel_program = ("import sys; sys.path.insert(0, sys.argv[1]); import wheel_backend; "
                             "print(wheel_backend.pack(sys.argv[2], sys.argv[3], {}))")
            name = run(sys.executable, "-c", wheel_program, PYTHON_DIR, build, folder).split()[-1]
            home = os.path.join(folder, "home")
            venv.create(home, system_site_packages=True, with_pip=True)
            python = os.path.join(home, "bin", "python")
            environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
            run(python, "-m", "pip", "install", "--no-index", "--no-deps", os.path.join(folder, name), env=environment,
                cwd=folder)
            program = ("import tremolo; m = tremolo.precompute(*tremolo.box((1, 1, 1), (2, 2, 2)), fixed='z<0.1', r=3, "
                       "linear_modes=2, order=2); print(tremolo.__file__, tremolo.find_program('tremolo-precompute'), "
                       "m.modes)")
            words = run(python, "-c", program, env=environment, cwd=folder).split()
            self.assertTrue(words[0].startswith(home), words)
            self.assertTrue(words[1].startswith(home), words)
            self.assertEqual(words[2], "3")
            run(python, "-m", "pip", "uninstall", "-y", "tremolo", env=environment, cwd=folder)


if __name__ == "__main__":
    unittest.main()
