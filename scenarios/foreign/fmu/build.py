"""Builds the vehicle: vehicle.fmu (FMI 2.0), vehicle-3.fmu (FMI 3.0), vehicle-stateless.fmu (FMI 2.0, cannot get or set its state).

`python3 build.py [FOLDER]` needs a C compiler (cc, or the program in CC), and writes into its own folder or FOLDER.
"""

import os
import platform
import subprocess
import sys
import tempfile
import zipfile
from pathlib import Path

HERE = Path(__file__).resolve().parent

#: Variables in the order of their value references: name, unit, start value or None, description. vehicle.h has the same.
VARIABLES = [
    ("wheel_force", "N", 0.0, "force on the wheel, upwards"),
    ("wheel_mass", "kg", 1.0, ""),
    ("body_mass", "kg", 4.0, ""),
    ("stiffness", "N/m", 2e7, "of the spring between them"),
    ("damping", "N.s/m", 8e3, "of the dashpot between them"),
    ("load", "N", 2e3, "on the body, downwards"),
    ("ramp", "s", 1e-3, "time in which the load grows"),
    ("wheel_z", "m", None, "displacement upwards"),
    ("wheel_v", "m/s", None, ""),
    ("body_z", "m", None, "displacement upwards"),
    ("body_v", "m/s", None, ""),
    ("load_work", "J", None, "work of the load"),
    ("damper_loss", "J", None, "energy dissipated by the dashpot"),
    ("kinetic_energy", "J", None, ""),
    ("spring_energy", "J", None, ""),
]
#: One id for all units: the versions differ only in the two names of the state's functions.
GUID = "{f0b1ad0e-6a5b-4b0c-9c1a-7d3e8b1c2a48}"


def variables(version):
    """The XML of the variables. Settable ones are an input (the first) or parameters; the rest are outputs."""
    rows = []
    for reference, (name, unit, start, description) in enumerate(VARIABLES):
        kind = "output" if start is None else "parameter" if reference else "input"
        varies = "fixed" if kind == "parameter" else "continuous"
        words = f'name="{name}" valueReference="{reference}" causality="{kind}" variability="{varies}" description="{description}"'
        value = f'unit="{unit}"' + ("" if start is None else f' start="{start}"')
        rows.append(f"<ScalarVariable {words}><Real {value}/></ScalarVariable>" if version == 2 else f"<Float64 {words} {value}/>")
    if version == 3:
        rows.append(f'<Float64 name="time" valueReference="{len(rows)}" causality="independent" variability="continuous"/>')
    return "\n    ".join(rows)


def description(version, state):
    """modelDescription.xml."""
    units = "".join(f'<Unit name="{unit}"/>' for unit in dict.fromkeys(row[1] for row in VARIABLES))
    outputs = [reference for reference, row in enumerate(VARIABLES) if row[2] is None]
    able, word = str(state).lower(), "FMUstate" if version == 2 else "FMUState"
    can = f'canHandleVariableCommunicationStepSize="true" canGetAndSet{word}="{able}" canSerialize{word}="{able}"'
    if version == 2:
        identity, unknowns = f'fmiVersion="2.0" guid="{GUID}"', "".join(f'<Unknown index="{k + 1}"/>' for k in outputs)
        unknowns = f"<Outputs>{unknowns}</Outputs><InitialUnknowns>{unknowns}</InitialUnknowns>"
    else:
        identity = f'fmiVersion="3.0" instantiationToken="{GUID}"'
        unknowns = "".join(f'<{tag} valueReference="{k}"/>' for tag in ("Output", "InitialUnknown") for k in outputs)
    return f"""<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription {identity} modelName="vehicle" description="a wheel on its suspension">
  <CoSimulation modelIdentifier="vehicle" {can}/>
  <UnitDefinitions>{units}</UnitDefinitions>
  <ModelVariables>
    {variables(version)}
  </ModelVariables>
  <ModelStructure>{unknowns}</ModelStructure>
</fmiModelDescription>
"""


def build(path, version=2, state=True):
    """Writes a unit."""
    folder = "binaries/linux64" if version == 2 else f"binaries/{platform.machine()}-linux"
    with tempfile.TemporaryDirectory() as work:
        library = Path(work) / "vehicle.so"
        flags = ["-O2", "-ffp-contract=off", "-Wall", "-shared", "-fPIC"] + ([] if state else ["-DSTATELESS"])
        subprocess.run([os.environ.get("CC", "cc"), *flags, "-o", library, HERE / f"fmi{version}.c"], check=True)
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as unit:
            unit.writestr("modelDescription.xml", description(version, state))
            unit.write(library, f"{folder}/vehicle.so")


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else HERE
    build(folder / "vehicle.fmu")
    build(folder / "vehicle-3.fmu", version=3)
    build(folder / "vehicle-stateless.fmu", state=False)
