"""The distribution hapticd-client: its wheel is built and installed without a network."""

import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest
import zipfile

PROJECT = os.environ["HAPTIC_PYTHON_PROJECT"]  # the folder with pyproject.toml, in the build
VERSION = os.environ["HAPTIC_VERSION"]


def run(*command: str) -> str:
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTHON")}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=170)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stdout + done.stderr
    return done.stdout


class Wheel(unittest.TestCase):
    @classmethod
    def setUpClass(cls) -> None:
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        project = os.path.join(cls.folder, "project")
        made = shutil.ignore_patterns("build", "wheel", "__pycache__")
        shutil.copytree(PROJECT, project, ignore=made)
        run(sys.executable, "-m", "pip", "wheel", "--no-build-isolation", "--no-deps", "--no-index",
            "--wheel-dir", cls.folder, project)
        cls.wheel = os.path.join(cls.folder, f"hapticd_client-{VERSION}-py3-none-any.whl")

    def test_it_holds_the_whole_package(self) -> None:
        names = set(zipfile.ZipFile(self.wheel).namelist())
        built = {os.path.relpath(os.path.join(folder, name), PROJECT)
                 for folder, _, files in os.walk(os.path.join(PROJECT, "haptic")) for name in files
                 if "__pycache__" not in folder}
        self.assertTrue({"haptic/py.typed", "haptic/_libhaptic.py", "haptic/_messages.py"} <= built)
        self.assertEqual({name for name in names if ".dist-info/" not in name}, built)
        self.assertTrue(any(name.endswith(".dist-info/LICENSE") for name in names))

    def test_it_installs_offline_and_imports(self) -> None:
        venv = os.path.join(self.folder, "venv")
        run(sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", venv)
        python = os.path.join(venv, "bin/python")
        run(sys.executable, "-m", "pip", "--python", python, "install", "--no-index", self.wheel)
        said = run(python, "-c", "import haptic; print(haptic.__version__, haptic.__file__); "
                   "haptic.Connection('127.0.0.1:1').close()").split()
        self.assertEqual(said[0], VERSION)
        self.assertTrue(said[1].startswith(venv), said)


class Version(unittest.TestCase):
    def test_it_is_the_projects(self) -> None:
        import haptic
        self.assertEqual(haptic.__version__, VERSION)
        self.assertTrue(re.fullmatch(r"\d+\.\d+\.\d+", VERSION))


if __name__ == "__main__":
    unittest.main()
