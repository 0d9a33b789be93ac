#!/usr/bin/env python3
"""Compares distances and impacts of contact with ipctk, the reference code of incremental potential contact.

    .ci/check_contact.py PROGRAM       the example contact_pairs, built

Of 25 000 pairs of every kind: squares of distances, the places of the closest points and derivatives, and mollifiers.
A third are general, a third on a grid of three values by axis, which are often flat, parallel or without length, and a
third almost so. Of 5 000 moving pairs of every kind: on the free way ipctk's distance stays what it should, at its end
it is down to that, and ipctk's own times of impact without a distance to be left are no earlier.
"""

import subprocess
import sys

import ipctk
import numpy as np

KINDS = ("node-node", "node-edge", "node-triangle", "edge-edge")
NODES = (2, 3, 4, 4)
PAIRS, MOVING = 25_000, 5_000
# [-] what results may differ by, of the square of a distance or of 1e-4 where it is smaller (sizes are about 1), and of
# derivatives or of 1e-2; besides, the rounding of ipctk's cross products over the square of the sine between edges
AGREE, ROUNDING = 1e-10, 2e-15
# [-] two places are equally near where the squares of their distances differ by less
TIE = 1e-12
# [-] share of the gap that is left, and by how much of it more the way may end early (src/engine/contact/impact.rs)
LEFT, SLACK = 0.1, 0.01
# [-] of ipctk's times of impact, which come before the exact one by no more
TIGHT = 1e-6

SQUARE = (
    ipctk.point_point_distance,
    ipctk.point_edge_distance,
    ipctk.point_triangle_distance,
    ipctk.edge_edge_distance,
)
SLOPE = (
    ipctk.point_point_distance_gradient,
    ipctk.point_edge_distance_gradient,
    ipctk.point_triangle_distance_gradient,
    ipctk.edge_edge_distance_gradient,
)
TYPE = (None, ipctk.point_edge_distance_type, ipctk.point_triangle_distance_type, ipctk.edge_edge_distance_type)
E, T, EE = ipctk.PointEdgeDistanceType, ipctk.PointTriangleDistanceType, ipctk.EdgeEdgeDistanceType
# Places of closest points as the example writes them, in ipctk's words.
NAMES = (
    {(0, 1): None},
    {(0, 1): E.P_E0, (0, 2): E.P_E1, (0, 112): E.P_E},
    {(0, 1): T.P_T0, (0, 2): T.P_T1, (0, 3): T.P_T2, (0, 112): T.P_E0, (0, 123): T.P_E1, (0, 131): T.P_E2}
    | {(0, 200): T.P_T},
    {(0, 2): EE.EA0_EB0, (0, 3): EE.EA0_EB1, (1, 2): EE.EA1_EB0, (1, 3): EE.EA1_EB1}
    | {(101, 2): EE.EA_EB0, (101, 3): EE.EA_EB1, (0, 123): EE.EA0_EB, (1, 123): EE.EA1_EB, (101, 123): EE.EA_EB},
)
# The pairs of a node and an edge on the border of a kind: all that ipctk says of elements without length or area.
BORDER = ((), ((0, 1, 2),), ((0, 1, 2), (0, 2, 3), (0, 3, 1)), ((0, 2, 3), (1, 2, 3), (2, 0, 1), (3, 0, 1)))


def ask(kind, x, d, thickness):
    """What the example finds for pairs of one kind: distance, places, derivatives, share, mollifier, its derivatives."""
    n = len(x)
    lengths = np.stack([np.linalg.norm(x[:, 1] - x[:, 0], axis=1), np.linalg.norm(x[:, 3] - x[:, 2], axis=1)], axis=1)
    columns = (
        np.full((n, 1), kind),
        x.reshape(n, 12),
        d.reshape(n, 12),
        thickness[:, None],
        np.full((n, 1), LEFT),
        lengths,
    )
    given = np.hstack(columns).astype("<f8").tobytes()
    out = subprocess.run([sys.argv[1]], input=given, stdout=subprocess.PIPE, check=True).stdout
    found = np.frombuffer(out, "<f8").reshape(n, 29)
    return found[:, 0], found[:, 1:3].astype(int), found[:, 3:15], found[:, 15], found[:, 16], found[:, 17:29]


def sine_squared(kind, x):
    """[-] of the angle between the two edges that make the normal, 0 where one has no length; 1 where there are none."""
    if kind < 2:
        return np.ones(len(x))
    u, v = (x[:, 2] - x[:, 1], x[:, 3] - x[:, 1]) if kind == 2 else (x[:, 1] - x[:, 0], x[:, 3] - x[:, 2])
    lengths = (u**2).sum(axis=1) * (v**2).sum(axis=1)
    return (np.cross(u, v) ** 2).sum(axis=1) / np.where(lengths > 0, lengths, 1)


def nearest_on_border(kind, x):
    """[m^2] by ipctk, edge by edge"""
    edges = ((x[a], x[b], x[c]) for a, b, c in BORDER[kind])
    return min(SQUARE[0](p, a) if (a == b).all() else SQUARE[1](p, a, b) for p, a, b in edges)


def compare_distances(kind, draw):
    """Largest differences over what is allowed, of squares of distances, places that are as near, derivatives and
    mollifiers; how many places differ; how many pairs have no length or area."""
    n = PAIRS
    grid = draw.integers(-1, 2, (n, 4, 3)).astype(float)
    almost = grid + draw.uniform(-1, 1, (n, 4, 3)) * draw.choice([1e-12, 1e-6, 1e-3], (n, 1, 1))
    x = np.where(np.arange(n)[:, None, None] % 3 == 0, draw.uniform(-1, 1, (n, 4, 3)), grid)
    x = np.where(np.arange(n)[:, None, None] % 3 == 2, almost, x)
    distance, places, gradient, _, mollifier, bend = ask(kind, x, np.zeros_like(x), np.zeros(n))
    sine = sine_squared(kind, x)
    worst, ties, borders = np.zeros(4), 0, 0
    for i in range(n):
        nodes = list(x[i, : NODES[kind]])
        name = NAMES[kind][tuple(places[i])]
        dtype = {} if name is None else {"dtype": name}
        # Where a triangle has no area ipctk takes the point for one inside of it, and has no number. `np.maximum` keeps
        # what is no number, `max` would not.
        flat = sine[i] < 1e-20 or (kind == 1 and (nodes[1] == nodes[2]).all())
        allowed = AGREE + ROUNDING / sine[i] if not flat else AGREE
        expected = nearest_on_border(kind, nodes) if flat else SQUARE[kind](*nodes)
        scale = max(expected, 1e-4)
        worst[0] = np.maximum(worst[0], abs(distance[i] ** 2 - expected) / scale / allowed)
        if not flat and name is not None and TYPE[kind](*nodes) != name:
            ties += 1
            worst[1] = np.maximum(
                worst[1], abs(SQUARE[kind](*nodes, **dtype) - expected) / scale / (TIE / AGREE * allowed)
            )
        borders += flat
        if not (flat and name in (T.P_T, EE.EA_EB)):
            slope = SLOPE[kind](*nodes, **dtype)
            ours = 2 * distance[i] * gradient[i, : 3 * NODES[kind]]
            worst[2] = np.maximum(worst[2], np.abs(ours - slope).max() / max(np.abs(slope).max(), 1e-2) / allowed)
        if kind == 3:
            threshold = ipctk.edge_edge_mollifier_threshold(*nodes)
            if threshold > 0:
                value, slope = (
                    of(*nodes, threshold) for of in (ipctk.edge_edge_mollifier, ipctk.edge_edge_mollifier_gradient)
                )
                off = np.maximum(abs(mollifier[i] - value), np.abs(bend[i] - slope).max() / max(np.abs(slope).max(), 1))
                worst[3] = np.maximum(worst[3], off / AGREE)
    return worst, ties, borders


def distance_on_the_way(kind, x, d, share):
    """[m] by ipctk"""
    return SQUARE[kind](*(x + share * d)) ** 0.5


def compare_impacts(kind, draw):
    """How many pairs meet, and their free shares over ipctk's times by its two methods."""
    n = MOVING
    first = (np.arange(4) < (2 if kind == 3 else 1))[:, None]
    apart = 2 * draw.uniform(-1, 1, (n, 1, 3))
    size = draw.choice([1, 0.3, 1e-2], (n, 1, 1))
    x = draw.uniform(-1, 1, (n, 4, 3)) * size + first * apart
    d = draw.uniform(-1, 1, (n, 4, 3)) * size - first * apart * draw.uniform(0, 2.5, (n, 1, 1))
    thickness = np.where(np.arange(n) % 2, 0.01, 0.0)
    distance, _, _, share, _, _ = ask(kind, x, d, thickness)
    gap = distance - thickness
    target = thickness + LEFT * gap
    ccd = ipctk.AdditiveCCD(conservative_rescaling=1 - LEFT)
    additive = (ccd.point_point_ccd, ccd.point_edge_ccd, ccd.point_triangle_ccd, ccd.edge_edge_ccd)[kind]
    tight = (None, None, ipctk.tight_inclusion.point_triangle_ccd, ipctk.tight_inclusion.edge_edge_ccd)[kind]
    ratios, before = [], []
    for i in np.flatnonzero(gap > 0):
        path = (kind, x[i, : NODES[kind]], d[i, : NODES[kind]])
        end = min(share[i], 1)
        least = min(distance_on_the_way(*path, end * s / 8) for s in range(9))
        assert least >= target[i] * (1 - 1e-9), ("it overshoots", KINDS[kind], x[i], d[i], share[i], least, target[i])
        most = target[i] + 1.01 * SLACK * LEFT * gap[i]
        last = distance_on_the_way(*path, end)
        assert share[i] == 2 or last <= most, ("it ends early", KINDS[kind], x[i], d[i], share[i], last, most)
        ends = [*path[1], *(path[1] + path[2])]
        met, time = additive(*ends, min_distance=thickness[i])
        if share[i] < 2 and met and time > 0:
            ratios.append(share[i] / time)
        if tight and thickness[i] == 0:
            met, time, _ = tight(*ends)
            assert not met or share[i] <= time + TIGHT, ("it is late", KINDS[kind], x[i], d[i], share[i], time)
            if met and time > 0:
                before.append(share[i] / time)
    return int((share < 2).sum()), np.array(ratios), np.array(before)


draw = np.random.default_rng(1)
said = []
for kind, name in enumerate(KINDS):
    worst, ties, borders = compare_distances(kind, draw)
    assert (worst < 1).all(), (name, "squares, ties, derivatives and mollifiers differ by this many times", worst)
    met, ratios, before = compare_impacts(kind, draw)
    assert met > MOVING / 5 and (kind == 0 or ties and borders), (name, met, ties, borders)
    assert np.median(ratios) >= 1, (name, "ways are shorter than by ipctk's additive method", np.median(ratios))
    tight = f", {np.median(before):.3f} of its tight ones" if len(before) else ""
    said.append(
        f"{name} {worst.max() * AGREE:.0e} ({ties} ties, {borders} degenerate), {met} of {MOVING} meet at "
        f"{ratios.min():.3f} to {ratios.max():.3f} of ipctk's additive times{tight}"
    )
print("contact: differences from ipctk of " + "; ".join(said))
