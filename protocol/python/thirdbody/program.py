"""Where the program `thirdbody` is."""

import os
import shutil
import sysconfig
from typing import Optional


def find_program(program: Optional[str] = None) -> Optional[str]:
    """`program` itself, or the one that THIRDBODY names, that came with this package, or that is on PATH. The one of the same wheel goes
    before PATH, where another release may be."""
    beside = shutil.which("thirdbody", path=sysconfig.get_path("scripts"))
    return program or os.environ.get("THIRDBODY") or beside or shutil.which("thirdbody")
