"""Solvers in Python for coupled runs of thirdbody.

A continuum (forces in, displacements out) or a layer of grains (velocities in, forces out) is a class with a few methods::

    import thirdbody

    class Rail(thirdbody.Continuum):
        ...

    thirdbody.participate(Rail)

`participant.<name>.command` of a scenario starts the program. `protocol/WIRE.md` describes the messages on the wire.
"""

from typing import Any

from .config import Config, Setting
from .continuum import Continuum
from .disks import DiskLayer
from .equilibrium import LinearEquilibrium
from .errors import ConfigurationError, Diverged, Fault, OutputError, ProtocolError
from .exchange import Interface, Side
from .fields import Field, Fields
from .layer import GrainLayer
from .mesh import crowned_grid, traction_matrix
from .modal import Modal
from .node import Description, Node, Outcome, Points, Term, Window, capabilities
from .runs import Run, RunError, Seeds, Study, SuspectRun, load, load_study, run, seeds, study, sweep
from .table import Table

__all__ = [
    "Config", "ConfigurationError", "Continuum", "Description", "DiskLayer", "Diverged", "Fault", "Field", "Fields", "GrainLayer",
    "Interface", "LinearEquilibrium", "Modal", "Node", "Outcome", "OutputError", "Points", "ProtocolError", "Run", "RunError", "Seeds", "Setting",
    "Side", "Study", "SuspectRun", "Table", "Term", "Window", "capabilities", "crowned_grid", "load", "load_study", "participate", "run", "seeds", "study", "sweep",
    "traction_matrix",
]


def __getattr__(name: str) -> Any:
    # Reading runs needs only NumPy, not the packages that solvers communicate with.
    if name == "participate":
        from .serve import participate

        return participate
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
