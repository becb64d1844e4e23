"""Where the package looks for the program."""

import os
import tempfile
import unittest
from pathlib import Path
from unittest import mock

from thirdbody.program import find_program


class FindProgram(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.beside, self.path = Path(folder.name) / "beside", Path(folder.name) / "path"
        for place in (self.beside, self.path):
            place.mkdir()
            (place / "thirdbody").touch(mode=0o755)
        scripts = mock.patch("sysconfig.get_path", return_value=str(self.beside))
        environment = mock.patch.dict(os.environ, {"PATH": str(self.path), "THIRDBODY": ""})
        for patch in (scripts, environment):
            patch.start()
            self.addCleanup(patch.stop)

    def test_the_program_of_the_same_wheel_goes_before_that_on_path(self):
        self.assertEqual(find_program(), str(self.beside / "thirdbody"))
        (self.beside / "thirdbody").unlink()
        self.assertEqual(find_program(), str(self.path / "thirdbody"))
        (self.path / "thirdbody").unlink()
        self.assertIsNone(find_program())

    def test_what_is_named_goes_before_both(self):
        with mock.patch.dict(os.environ, {"THIRDBODY": "/of/the/environment"}):
            self.assertEqual(find_program(), "/of/the/environment")
            self.assertEqual(find_program("/of/the/call"), "/of/the/call")


if __name__ == "__main__":
    unittest.main()
