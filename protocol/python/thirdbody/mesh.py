"""The mesh of the built-in rail, for rails by other programs."""

from __future__ import annotations

from typing import Tuple

import numpy as np

from .config import Config
from .errors import ConfigurationError

#: Bisections after which the growth of a grading is as exact as a double.
_BISECTIONS = 60


def crowned_grid(config: Config) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes and quadrilaterals of a rail: x and y (m), rows from below, each from the left, the top of the crown being the origin; and
    the four nodes of each element, counterclockwise, by their index in all rows.

    It is uniform with `size_m` within `fine_width_m` and `fine_depth_m`, and graded from there on by `side_columns` on either side
    and `depth_rows`, up to `width_m` and `height_m`; `crown_radius_m` takes its drop off every column, from nothing at the base.
    """
    size, crown = config.number("size_m", above=0), config.number("crown_radius_m", above=0)
    width, height = config.number("width_m", above=0), config.number("height_m", above=0)
    fine = config.number("fine_width_m", above=0), config.number("fine_depth_m", above=0)
    right = _graded(0.5 * width, 0.5 * fine[0], size, config.integer("side_columns", above=0))
    depth = _graded(height, fine[1], size, config.integer("depth_rows", above=0))
    if crown < 0.5 * width:
        raise ConfigurationError(f"crown_radius_m: {crown} m is less than half of the width of {width} m")
    x, below = np.meshgrid(np.append(-right[:0:-1], right), depth[::-1])
    drop = x**2 / (crown + np.sqrt(crown**2 - x**2))
    rows, columns = x.shape
    corner = (np.arange(rows - 1)[:, None] * columns + np.arange(columns - 1)).reshape(-1, 1)
    return x, -drop * (1.0 - below / height) - below, corner + [0, 1, columns + 1, columns]


def _graded(length: float, fine: float, size: float, cells: int) -> np.ndarray:
    """Places from 0 to `length`: `size` apart up to `fine`, then cells of the sizes size r^k, k = 0, 1, ..., that fill the rest."""
    inner = np.linspace(0.0, fine, int(round(fine / size)) + 1)
    sizes = inner[-1:]
    low, high = 0.0, (length - fine) / size + 1.0
    for _ in range(_BISECTIONS):
        ratio = 0.5 * (low + high)
        sizes = size * ratio ** np.arange(cells)
        low, high = (ratio, high) if sizes.sum() < length - fine else (low, ratio)
    return np.append(inner, fine + np.cumsum(sizes))
