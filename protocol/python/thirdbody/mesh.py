"""The mesh of the built-in rail, for rails by other programs, and the forces on edges of higher order."""

from __future__ import annotations

from typing import Tuple

import numpy as np

from .config import Config
from .errors import ConfigurationError

#: Bisections after which the growth of a grading has the precision of a double.
_BISECTIONS = 60


def crowned_grid(config: Config, order: int = 1) -> Tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes and quadrilaterals of a rail: x and y (m), rows from below, each from the left, with the origin at the top of the crown; and
    the four corners of each element, counterclockwise, by their index in all rows.

    The mesh is uniform with `size_m` within `fine_width_m` and `fine_depth_m`, and graded beyond by `side_columns` on either side
    and `depth_rows`, up to `width_m` and `height_m`. `crown_radius_m` lowers every column by its drop, which grows from zero at the base.
    Elements of a higher `order` have nodes between their corners, at the Gauss-Lobatto points (the middle for order 2). These nodes get
    the drop at their own position, so that all nodes of the crown lie on the circle.
    """
    size, crown = config.number("size_m", above=0), config.number("crown_radius_m", above=0)
    width, height = config.number("width_m", above=0), config.number("height_m", above=0)
    fine = config.number("fine_width_m", above=0), config.number("fine_depth_m", above=0)
    right = _graded(0.5 * width, 0.5 * fine[0], size, config.integer("side_columns", above=0))
    depth = _graded(height, fine[1], size, config.integer("depth_rows", above=0))
    if crown < 0.5 * width:
        raise ConfigurationError(f"crown_radius_m: {crown} m is less than half of the width of {width} m")
    right, depth = _with_inner_nodes(right, order), _with_inner_nodes(depth, order)
    x, below = np.meshgrid(np.append(-right[:0:-1], right), depth[::-1])
    drop = x**2 / (crown + np.sqrt(crown**2 - x**2))
    rows, columns = x.shape
    corner = (np.arange(0, rows - 1, order)[:, None] * columns + np.arange(0, columns - 1, order)).reshape(-1, 1)
    return x, -drop * (1.0 - below / height) - below, corner + order * np.array([0, 1, columns + 1, columns])


def traction_matrix(x: np.ndarray, order: int) -> np.ndarray:
    """B of f = B^T f_c and u_c = B u, between the coupler's surface of straight lines and edges of the given order.

    f_c are forces on the lines between the nodes at `x` (m), f the forces on the same nodes as nodes of edges, `order` + 1 on each. Both
    come from the same traction, linear between its values t at the nodes: f_c = M t with M = int h h^T and the hats h, and f = G t with
    G = int q h^T and the shape functions q of the edges. So B^T = G M^-1; it keeps the force and the moment, and the work f_c u_c = f u.
    """
    mass, mixed = np.zeros((x.size, x.size)), np.zeros((x.size, x.size))
    place, weight = np.polynomial.legendre.leggauss(order // 2 + 2)
    for line in range(x.size - 1):
        corner = line - line % order
        nodes, others = x[corner : corner + order + 1], ~np.eye(order + 1, dtype=bool)
        length = x[line + 1] - x[line]
        s = x[line] + 0.5 * length * (1.0 + place)
        hats = np.stack([x[line + 1] - s, s - x[line]]) / length
        shapes = np.stack([np.prod([(s - b) / (a - b) for b in nodes[row]], axis=0) for a, row in zip(nodes, others)])
        mass[line : line + 2, line : line + 2] += (0.5 * length * weight * hats) @ hats.T
        mixed[corner : corner + order + 1, line : line + 2] += (0.5 * length * weight * shapes) @ hats.T
    return np.linalg.solve(mass, mixed.T)


def _graded(length: float, fine: float, size: float, cells: int) -> np.ndarray:
    """Positions from 0 to `length`: `size` apart up to `fine`, then cells of the sizes size r^k, k = 0, 1, ..., that fill the rest."""
    inner = np.linspace(0.0, fine, int(round(fine / size)) + 1)
    sizes = inner[-1:]
    low, high = 0.0, (length - fine) / size + 1.0
    for _ in range(_BISECTIONS):
        ratio = 0.5 * (low + high)
        sizes = size * ratio ** np.arange(cells)
        low, high = (ratio, high) if sizes.sum() < length - fine else (low, ratio)
    return np.append(inner, fine + np.cumsum(sizes))


def _with_inner_nodes(corners: np.ndarray, order: int) -> np.ndarray:
    """Positions of the corners of cells and of the nodes between them: in each cell the zeros of the Legendre polynomial's derivative."""
    zeros = np.polynomial.legendre.Legendre.basis(order).deriv().roots()
    within = np.append(0.0, 0.5 * (1.0 + zeros))
    return np.append((corners[:-1, None] + within * np.diff(corners)[:, None]).reshape(-1), corners[-1])
