"""Solvers in Python for coupled runs of thirdbody.

A continuum (forces in, displacements out) or a layer of grains (velocities in, forces out) is a class of a handful of methods::

    import thirdbody

    class Rail(thirdbody.Continuum):
        ...

    thirdbody.participate(Rail)

`participant.<name>.command` of a scenario starts the program. `protocol/WIRE.md` describes what goes over the wire.
"""

from .config import Config, Setting
from .continuum import Continuum
from .errors import ConfigurationError, Diverged, Fault, OutputError, ProtocolError
from .layer import GrainLayer
from .node import Description, Node, Outcome, Points, Term, Window, capabilities
from .runs import Run, RunError, load, run
from .serve import participate

__all__ = [
    "Config", "ConfigurationError", "Continuum", "Description", "Diverged", "Fault", "GrainLayer", "Node", "Outcome",
    "OutputError", "Points", "ProtocolError", "Run", "RunError", "Setting", "Term", "Window", "capabilities", "load",
    "participate", "run",
]
