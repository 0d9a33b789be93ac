"""Meshes that a surface is embedded in: a box of tetrahedra that is fine about the surface, and forces on the surface.

`canopy_fem.embedded` is made of it. Only numpy is needed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

__all__ = ["Box", "box", "nearest", "nodal_forces"]

_Array = npt.NDArray[np.float64]
_Indices = npt.NDArray[np.int64]
# Corners (x + 2 y + 4 z) of the six tetrahedra of a brick, all about one diagonal, so that neighbours fit.
_BRICK = np.array([[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]])
# How many triangles are tried for the one that is nearest to a point.
_CANDIDATES = 12


class Box(NamedTuple):
    """A box of tetrahedra."""

    nodes: _Array
    """[m] (n, 3)"""
    tetrahedra: _Indices
    """numbers of nodes, (t, 4), with positive volume"""
    low: _Array
    """[m] (3,)"""
    high: _Array
    """[m] (3,)"""
    size: float
    """[m] edge of a brick where it is fine"""

    def side(self, axis: int, end: int) -> _Indices:
        """Nodes of a face: axis 0, 1, 2, and end 0 (low) or 1 (high)."""
        at = (self.low, self.high)[end][axis]
        return np.flatnonzero(self.nodes[:, axis] == at)


def box(low: npt.ArrayLike, high: npt.ArrayLike, fine: npt.ArrayLike, size: float, growth: float = 1.25) -> Box:
    """A box of bricks, of six tetrahedra each, whose edges grow with the distance from a fine region.

    Args:
        low, high: [m] corners of the box, (3,).
        fine: [m] corners of the region with bricks of one size, (2, 3); within the box.
        size: [m] edge of these bricks.
        growth: [-] factor from brick to brick outside of it, 1 or more.

    Raises:
        ValueError: corners that do not enclose a volume, a fine region outside the box, a size or growth out of range.

    >>> mesh = box([-1, -1, -1], [1, 1, 2], [[-0.5] * 3, [0.5] * 3], 0.25)
    >>> len(mesh.nodes), len(mesh.tetrahedra)
    (891, 3840)
    """
    low, high = np.asarray(low, dtype=float), np.asarray(high, dtype=float)
    inner = np.asarray(fine, dtype=float)
    if low.shape != (3,) or high.shape != (3,) or inner.shape != (2, 3):
        raise ValueError("low and high have 3 coordinates, fine has two corners of 3")
    if not ((low < inner[0]) & (inner[0] < inner[1]) & (inner[1] < high)).all():
        raise ValueError(f"the fine region {inner.tolist()} must have a volume, and lie within {low} to {high}")
    if not (np.isfinite(size) and size > 0 and np.isfinite(growth) and growth >= 1):
        raise ValueError(f"size {size!r} m must be above 0, growth {growth!r} at least 1")
    lines = [
        _line(float(low[axis]), float(inner[0, axis]), float(inner[1, axis]), float(high[axis]), size, growth)
        for axis in range(3)
    ]
    x, y, z = np.meshgrid(*lines, indexing="ij")
    nodes = np.stack([x.ravel(), y.ravel(), z.ravel()], axis=1)
    number = np.arange(len(nodes)).reshape(x.shape)
    corners = [
        number[i : i - 1 or None, j : j - 1 or None, k : k - 1 or None].ravel()
        for k in (0, 1) for j in (0, 1) for i in (0, 1)
    ]  # fmt: skip
    return Box(nodes, np.stack(corners, axis=1)[:, _BRICK].reshape(-1, 4), low, high, float(size))


def _line(low: float, first: float, last: float, high: float, size: float, growth: float) -> _Array:
    """Coordinates along one axis."""
    inner = np.linspace(first, last, max(1, round((last - first) / size)) + 1)

    def outwards(length: float) -> _Array:
        count = 1
        while size * sum(growth**i for i in range(1, count + 1)) < length * (1 - 1e-9):
            count += 1
        steps = growth ** np.arange(1, count + 1)
        return np.asarray(np.cumsum(steps) / steps.sum() * length)

    before, after = first - outwards(first - low)[::-1], last + outwards(high - last)
    # The ends exactly, for `side`.
    before[0], after[-1] = low, high
    return np.concatenate([before, inner, after])


def nodal_forces(points: _Array, triangles: _Indices, at: _Array, forces: _Array) -> _Array:
    """[N] forces on the nodes of a surface, (n, 3), with the sum and the moment of forces that act near to it.

    Each force goes to the nearest triangle, whose corners share it by its place there. What is then missing of the
    moment about the triangle is made good by forces at its corners without a sum.

    Args:
        points: [m] nodes of the surface, (n, 3).
        triangles: their numbers, (t, 3).
        at: [m] where the forces act, (m, 3).
        forces: [N] (m, 3).
    """
    if not len(at):
        return np.zeros((len(points), 3))
    which, share = nearest(points, triangles, at)
    corners = points[triangles]
    pushed = np.zeros((len(triangles), 3, 3))
    np.add.at(pushed, which, share[:, :, None] * forces[:, None, :])
    # [N m] about the mean of the corners
    arms = corners - corners.mean(axis=1, keepdims=True)
    moment = np.zeros((len(triangles), 3))
    np.add.at(moment, which, np.cross(at - corners.mean(axis=1)[which], forces))
    missing = moment - np.cross(arms, pushed).sum(axis=1)
    square = (arms**2).sum(axis=(1, 2))[:, None, None] * np.eye(3) - np.einsum("tia,tib->tab", arms, arms)
    turn = np.einsum("tab,tb->ta", np.linalg.pinv(square, hermitian=True), missing)
    pushed += np.cross(turn[:, None, :], arms)
    total = np.zeros((len(points), 3))
    np.add.at(total, triangles, pushed)
    return total


def nearest(points: _Array, triangles: _Indices, at: _Array) -> tuple[_Indices, _Array]:
    """The nearest triangle of each place (m, 3), (m,), and the shares of its corners in its nearest point, (m, 3).

    Among the triangles whose centres are nearest, so that it is exact where triangles are of like size.
    """
    corners = points[triangles]
    centres = corners.mean(axis=1)
    count = min(_CANDIDATES, len(triangles))
    best, share = np.empty(len(at), dtype=np.int64), np.empty((len(at), 3))
    # Not all at once, for memory.
    for start in range(0, len(at), 1024):
        some = at[start : start + 1024]
        gap = ((some[:, None, :] - centres) ** 2).sum(axis=2)
        near = np.argpartition(gap, count - 1, axis=1)[:, :count]
        shares = _shares(corners[near], some[:, None, :])
        gap = ((np.einsum("mkc,mkcx->mkx", shares, corners[near]) - some[:, None, :]) ** 2).sum(axis=2)
        first = gap.argmin(axis=1)
        rows = np.arange(len(some))
        best[start : start + 1024], share[start : start + 1024] = near[rows, first], shares[rows, first]
    return best, share


def _shares(corners: _Array, at: _Array) -> _Array:
    """Barycentric coordinates of the point of each triangle (..., 3, 3) that is nearest to a place (..., 3)."""
    a, b, c = corners[..., 0, :], corners[..., 1, :], corners[..., 2, :]
    normal = np.cross(b - a, c - a)
    area = (normal**2).sum(axis=-1)
    area = np.where(area > 0, area, 1.0)
    inside = np.stack(
        [(np.cross(q - p, at - p) * normal).sum(axis=-1) / area for p, q in ((b, c), (c, a), (a, b))], axis=-1
    )
    best = inside
    gap = np.where((inside >= 0).all(axis=-1), -1.0, np.inf)
    for first, second in ((0, 1), (1, 2), (2, 0)):
        start, side = corners[..., first, :], corners[..., second, :] - corners[..., first, :]
        length = (side**2).sum(axis=-1)
        along = np.clip(((at - start) * side).sum(axis=-1) / np.where(length > 0, length, 1.0), 0.0, 1.0)
        far = ((start + along[..., None] * side - at) ** 2).sum(axis=-1)
        edge = np.zeros_like(inside)
        edge[..., first], edge[..., second] = 1.0 - along, along
        best = np.where((far < gap)[..., None], edge, best)
        gap = np.minimum(gap, far)
    return best
