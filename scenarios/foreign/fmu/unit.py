"""A body with a few points from a co-simulation unit of FMI 2.0 or 3.0 (FMU): forces go in, displacements come out.

The scenario names the unit, its communication step, and the variables of each point. A unit that can get, set and serialize its
state supports repeats and resume; another one computes each window once, in a staggered scheme. A minus before a name
("-contact_force") changes the sign of the unit's variable.
"""

import tempfile
from pathlib import Path

import fmpy
import fmpy.simulation
import numpy as np
import thirdbody

#: Keys of a point with numbers, and keys that name a variable in a direction: an unnamed displacement is held, an unnamed force is zero.
NUMBERS, NAMES = ("x_m", "y_m", "length_m", "mass_kg"), ("force_x", "force_y", "displacement_x", "displacement_y")
BEFORE_INITIALIZATION = ("input", "parameter", "structuralParameter")


class Unit(thirdbody.Continuum):
    kind = "fmu"
    software = f"FMPy {fmpy.__version__}"

    def __init__(self, config, setting):
        super().__init__(config, setting)
        self.step_s = config.number("step_s", above=0)
        self.sets = (config.get("set"),)
        self.outward = {self.sets[0]: config.get("outward")}
        self.place = self.read_points(config.get("points"))
        path = config.get("unit")
        if not Path(path).is_file():
            raise thirdbody.ConfigurationError(f"participant.config.unit: {path} is missing; build.py makes the units of its folder")
        self.model = fmpy.read_model_description(path)
        if self.model.coSimulation is None:
            raise thirdbody.ConfigurationError(f"participant.config.unit: {path} is for model exchange, not for co-simulation")
        self.software = f"{self.model.modelName} (FMI {self.model.fmiVersion}) by FMPy {fmpy.__version__}"
        can = self.model.coSimulation
        self.rollback = bool(can.canGetAndSetFMUstate and can.canSerializeFMUstate)
        self.variables = {variable.name: variable for variable in self.model.modelVariables}
        self.inputs = [self.named(point.get(key, "")) for point in self.place for key in NAMES[:2]]
        self.motions = [self.named(point.get(key, "")) for point in self.place for key in NAMES[2:]]
        self.reported = {name: self.named(variable) for name, variable in config.get("signals", {}).items()}
        terms = config.get("energy", {})
        self.terms = {role: {name: self.named(v) for name, v in named.items()} for role, named in terms.items()}
        outputs = [*self.motions, *self.reported.values(), *(v for named in self.terms.values() for v in named.values())]
        #: Variables that are read after each window, without repetition.
        self.outputs = sorted({reference for _, reference in outputs if reference is not None})
        self.forces = sorted({reference for _, reference in self.inputs if reference is not None})
        self.folder = tempfile.TemporaryDirectory(prefix="thirdbody-fmu-")
        self.unit = fmpy.simulation.instantiate_fmu(fmpy.extract(path, self.folder.name), self.model, "CoSimulation")
        two = self.model.fmiVersion.startswith("2")
        self.get, self.set = (self.unit.getReal, self.unit.setReal) if two else (self.unit.getFloat64, self.unit.setFloat64)
        if two:
            self.unit.setupExperiment(startTime=0.0)
        self.start(config.get("start", {}))
        self.unit.enterInitializationMode()
        self.unit.exitInitializationMode()
        self.begun = self.take(0)
        # A signal would leave the unit's files behind, so they are removed now, except resources that it may still read.
        if not Path(self.folder.name, "resources").is_dir():
            self.folder.cleanup()

    def read_points(self, points):
        """The points of the scenario, each a table with positions and names."""
        for row, point in enumerate(points):
            unknown = set(point) - set(NUMBERS) - set(NAMES)
            if unknown or not {"x_m", "y_m"} <= set(point):
                what = f"no such key {sorted(unknown)}" if unknown else "x_m and y_m are required"
                raise thirdbody.ConfigurationError(f"participant.config.points[{row}]: {what}; known keys: {', '.join(NUMBERS + NAMES)}")
        return points

    def named(self, name):
        """The sign and the value reference of a variable; no reference for an empty name."""
        if not name:
            return 1.0, None
        variable = self.variables.get(name.removeprefix("-"))
        if variable is None or variable.type not in ("Real", "Float64"):
            raise thirdbody.ConfigurationError(f"participant.config: {self.model.modelName} has no real variable `{name}`")
        return (-1.0 if name.startswith("-") else 1.0), variable.valueReference

    def start(self, values):
        """Sets parameters and inputs before the initialization."""
        for name, value in values.items():
            _, reference = self.named(name)
            if self.variables[name].causality not in BEFORE_INITIALIZATION:
                raise thirdbody.ConfigurationError(f"participant.config.start.{name} is a {self.variables[name].causality} of the unit")
            self.set([reference], [float(value)])

    def take(self, steps):
        """The state of the unit: its bytes if it can serialize them, the steps since the start, and its outputs."""
        kept = b""
        if self.rollback:
            handle = self.unit.getFMUState()
            kept = self.unit.serializeFMUState(handle)
            self.unit.freeFMUState(handle)
        return {"unit": kept, "steps": steps, "read": np.array(self.get(self.outputs))}

    def put(self, state):
        """Sets the state of the unit."""
        handle = self.unit.deserializeFMUState(state["unit"])
        self.unit.setFMUState(handle)
        self.unit.freeFMUState(handle)

    def points(self, set_name):
        columns = {key: [point.get(key, 0.0) for point in self.place] for key in NUMBERS}
        if not any(columns["length_m"]):
            columns["length_m"] = None
        return thirdbody.Points(**columns)

    def rest(self):
        return self.begun

    def step(self, state, force, n):
        if self.rollback:
            self.put(state)
        sums = dict.fromkeys(self.forces, 0.0)
        for (sign, reference), component in zip(self.inputs, force.reshape(-1).tolist()):
            if reference is not None:
                sums[reference] += sign * component
        self.set(list(sums), list(sums.values()))
        for k in range(state["steps"], state["steps"] + n):
            answer = self.unit.doStep(k * self.step_s, self.step_s, not self.rollback)
            # FMI 3.0 reports events, termination and an early return.
            if answer and (answer[1] or answer[2]):
                raise thirdbody.Diverged(f"{self.model.modelName} ended its step from {k * self.step_s} s at {answer[3]} s")
        return self.take(state["steps"] + n)

    def value(self, state, named):
        sign, reference = named
        return 0.0 if reference is None else sign * float(state["read"][self.outputs.index(reference)])

    def displacement(self, state):
        moved = [self.value(state, named) - self.value(self.begun, named) for named in self.motions]
        return np.array(moved).reshape(-1, 2)

    def energy(self, state):
        if not self.terms:
            return None
        return {
            role: {name: self.value(state, v) - self.value(self.begun, v) for name, v in named.items()}
            for role, named in self.terms.items()
        }

    def signals(self, state):
        return {name: self.value(state, named) for name, named in self.reported.items()}


thirdbody.participate(Unit)
