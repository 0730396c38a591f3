"""Builds the wheel of the package `tremolo` with CMake: the back end of pyproject.toml (PEP 517).

It uses what is installed, as the rest of the build does, and so needs no network and no package of Python. The wheel has
the module, and the programs tremolo-precompute and tremolo, which are linked to the PETSc of this machine.

Settings (pip install . --config-settings KEY=VALUE): `build` is the folder of the build, by default build/wheel;
`programs=no` leaves the programs out.
"""

import base64
import hashlib
import os
import pathlib
import re
import stat
import subprocess
import sys
import sysconfig
import zipfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
PROGRAMS = ("tremolo-precompute", "tremolo")


def _version() -> str:
    text = (ROOT / "CMakeLists.txt").read_text(encoding="utf-8")
    found = re.search(r"project\(tremolo VERSION ([0-9.]+)", text)
    assert found
    return found[1]


def _tag() -> str:
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    platform = sysconfig.get_platform().replace("-", "_").replace(".", "_")
    return f"{python}-{python}-{platform}"


def _metadata() -> str:
    return (f"Metadata-Version: 2.1\nName: tremolo\nVersion: {_version()}\n"
            "Summary: Deformable solids that vibrate in real time without losing their energy\n"
            "License: MIT\nRequires-Python: >=3.9\nRequires-Dist: numpy\n"
            "Provides-Extra: mesh\nRequires-Dist: scipy; extra == 'mesh'\nRequires-Dist: meshio; extra == 'mesh'\n")


def _run(*command: object) -> None:
    words = [str(word) for word in command]
    print("+", " ".join(words), flush=True)
    # pip gives the child a PYTHONPATH of its own, which is nothing to the build.
    environment = {key: value for key, value in os.environ.items() if not key.startswith("PYTHON")}
    subprocess.run(words, check=True, env=environment)


def _built(settings: dict) -> pathlib.Path:
    """Configures and builds; returns the folder of the build."""
    build = pathlib.Path(settings.get("build", ROOT / "build" / "wheel")).resolve()
    programs = settings.get("programs", "yes") != "no"
    python = os.path.realpath(getattr(sys, "_base_executable", sys.executable))
    fresh = not (build / "CMakeCache.txt").exists()
    options = []
    if fresh:
        options = [f"-DTREMOLO_PYTHON={python}", "-DTREMOLO_BUILD_PYTHON=ON", "-DCMAKE_BUILD_TYPE=Release",
                   "-DTREMOLO_BUILD_TESTS=OFF", "-DTREMOLO_BUILD_MESHER=OFF", "-DTREMOLO_SHARED=OFF",
                   f"-DTREMOLO_BUILD_PRECOMPUTE={'ON' if programs else 'OFF'}"]
    _run("cmake", "-S", ROOT, "-B", build, *options)
    targets = ["python", *(PROGRAMS if programs else ())]
    known = subprocess.run(["cmake", "--build", str(build), "--target", "help"], capture_output=True, text=True,
                           check=True).stdout
    names = set(re.findall(r"[\w.-]+", known))
    if "python" not in names:
        raise RuntimeError("the module cannot be built: install python3-dev and pybind11-dev")
    targets = [target for target in targets if target in names]
    _run("cmake", "--build", build, "--parallel", os.cpu_count() or 1, "--target", *targets)
    return build


def _contents(build: pathlib.Path, settings: dict):
    """(name in the wheel, bytes, may be executed) of all files."""
    suffix = sysconfig.get_config_var("EXT_SUFFIX")
    module = build / "python" / "tremolo" / f"_tremolo{suffix}"
    if not module.exists():
        raise RuntimeError(f"{module} was not built: is it of another Python than {sys.executable}?")
    for path in sorted((HERE / "tremolo").iterdir()):
        if path.suffix in (".py", ".pyi") or path.name == "py.typed":
            yield f"tremolo/{path.name}", path.read_bytes(), False
    yield f"tremolo/{module.name}", module.read_bytes(), True
    if settings.get("programs", "yes") != "no":
        for name in PROGRAMS:
            program = build / "bin" / name
            if program.exists():
                yield f"tremolo/bin/{name}", program.read_bytes(), True


def pack(build, wheel_directory, settings) -> str:
    """Makes the wheel of a finished build; returns its file name."""
    information = f"tremolo-{_version()}.dist-info"
    name = f"tremolo-{_version()}-{_tag()}.whl"
    records = []
    with zipfile.ZipFile(os.path.join(wheel_directory, name), "w", zipfile.ZIP_DEFLATED) as wheel:
        def put(path, data, executable=False):
            entry = zipfile.ZipInfo(path, (2020, 1, 1, 0, 0, 0))
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = (stat.S_IFREG | (0o755 if executable else 0o644)) << 16
            wheel.writestr(entry, data)
            digest = base64.urlsafe_b64encode(hashlib.sha256(data).digest()).rstrip(b"=").decode()
            records.append(f"{path},sha256={digest},{len(data)}\n")

        for path, data, executable in _contents(pathlib.Path(build), settings):
            put(path, data, executable)
        put(f"{information}/METADATA", _metadata().encode())
        put(f"{information}/WHEEL",
            f"Wheel-Version: 1.0\nGenerator: tremolo\nRoot-Is-Purelib: false\nTag: {_tag()}\n".encode())
        put(f"{information}/LICENSE", (ROOT / "LICENSE").read_bytes())
        path = f"{information}/RECORD"
        records.append(f"{path},,\n")
        entry = zipfile.ZipInfo(path, (2020, 1, 1, 0, 0, 0))
        entry.external_attr = (stat.S_IFREG | 0o644) << 16
        wheel.writestr(entry, "".join(records))
    return name


def build_wheel(wheel_directory, config_settings=None, metadata_directory=None):
    settings = config_settings or {}
    return pack(_built(settings), wheel_directory, settings)


def get_requires_for_build_wheel(config_settings=None):
    return []


def get_requires_for_build_sdist(config_settings=None):
    return []


def prepare_metadata_for_build_wheel(metadata_directory, config_settings=None):
    information = f"tremolo-{_version()}.dist-info"
    folder = os.path.join(metadata_directory, information)
    os.makedirs(folder)
    with open(os.path.join(folder, "METADATA"), "w", encoding="utf-8") as file:
        file.write(_metadata())
    return information


def build_sdist(sdist_directory, config_settings=None):
    raise NotImplementedError("the package is built from the project's tree: `pip install .` there")
