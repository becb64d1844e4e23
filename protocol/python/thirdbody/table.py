"""Tables of numbers with named columns."""

from __future__ import annotations

import csv
import difflib
from pathlib import Path
from typing import Any, Dict, Iterable, List, Sequence

import numpy as np


def unknown(what: str, name: str, known: Iterable[str]) -> str:
    """The message for an unknown name, with the nearest known one."""
    known = list(known)
    lasts = {key.rsplit(".", 1)[-1]: key for key in known}
    near = difflib.get_close_matches(name, known, 1) or difflib.get_close_matches(name.rsplit(".", 1)[-1], lasts, 1)
    meant = f"did you mean `{near[0]}`?" if near else f"{what}s: {', '.join(known)}"
    return f"no {what} `{name}`; {meant}"


class Results(Dict[str, float]):
    """Results by name, unit in the name; the error for an unknown name proposes the nearest one."""

    def __missing__(self, name: str) -> float:
        raise KeyError(unknown("result", name, self))


class Table(Dict[str, np.ndarray]):
    """Columns by name, unit in the name: `signals["wheel_y_m"]`. `to_pandas()` gives a DataFrame."""

    def to_pandas(self) -> Any:
        """A pandas DataFrame; needs pandas."""
        try:
            import pandas
        except ImportError as error:
            raise ImportError("a DataFrame needs pandas: pip install pandas") from error
        return pandas.DataFrame(dict(self))

    def column(self, name: str) -> np.ndarray:
        """The column of this name, with or without a participant's name in front: `wheel_y_m` finds `third-body.wheel_y_m`."""
        found = [key for key in self if key == name or key.endswith("." + name)]
        if not found:
            raise KeyError(unknown("column", name, self))
        if name not in found and len(found) > 1:
            raise KeyError(f"several columns `{name}`: {', '.join(found)}")
        return self[name if name in found else found[0]]

    def __missing__(self, name: str) -> np.ndarray:
        raise KeyError(unknown("column", name, self))

    def has(self, name: str) -> bool:
        """True if `column(name)` finds one."""
        try:
            self.column(name)
        except KeyError:
            return False
        return True

    def __repr__(self) -> str:
        rows = len(next(iter(self.values()), ()))
        return f"Table({rows} rows of {', '.join(self)})"


def read_table(path: Path) -> Table:
    """Reads a CSV file of a run: numbers if all values of a column are numbers, texts otherwise. Ignores an unfinished last line of
    a killed run."""
    with open(path, newline="", encoding="utf-8") as file:
        lines = list(csv.reader(file))
    if not lines:
        raise ValueError(f"{path} is empty: the run was killed before it wrote its first line")
    names, rows = lines[0], lines[1:]
    if rows and len(rows[-1]) < len(names):
        rows = rows[:-1]
    uneven = [number for number, row in enumerate(rows, 2) if len(row) != len(names)]
    if uneven:
        raise ValueError(f"{path}, line {uneven[0]} has {len(rows[uneven[0] - 2])} values for {len(names)} columns: it is damaged")
    columns: Iterable[Sequence[str]] = zip(*rows) if rows else [()] * len(names)
    return Table((name, _column(list(values))) for name, values in zip(names, columns))


def _column(values: List[str]) -> np.ndarray:
    try:
        return np.array([float(value) if value else np.nan for value in values])
    except ValueError:
        return np.array(values)
