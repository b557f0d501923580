from __future__ import annotations

import math

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from scaloft_fi.mutants.operator import Facts, TapContext
from scaloft_fi.mutants.reference.mapping import invert_map
from scaloft_fi.stack.reference.messages import ObstacleMap


@given(
    origin=arrays(np.float64, 3, elements=st.floats(-20.0, 20.0)),
    off=arrays(np.float64, st.tuples(st.integers(0, 30), st.just(3)), elements=st.floats(-2.0, 2.0)),
    cell_m=st.sampled_from([0.1, 0.15, 0.25]),
    radius_m=st.sampled_from([0.3, 0.7, 1.5]),
)
def test_an_inverted_map_has_every_cell_around_that_is_not_occupied_once_and_in_order(origin, off, cell_m, radius_m):
    here, reach = np.floor(origin / cell_m).astype(int), math.ceil(radius_m / cell_m)
    taken = {tuple(cell) for cell in np.floor((origin + off) / cell_m).astype(int).tolist()}
    free = [
        cell
        for i in range(-reach, reach + 1)
        for j in range(-reach, reach + 1)
        for k in (-1, 0, 1)
        if np.hypot(i, j) * cell_m <= radius_m and (cell := tuple((here + np.array([i, j, k])).tolist())) not in taken
    ]
    context = TapContext(0.05, np.random.default_rng(0), facts=Facts(settings={"memory": {"voxel_m": cell_m}}))
    told = invert_map(context, radius_m=radius_m)(0.0, ObstacleMap(0.0, origin + off, 1.0, origin))
    assert told.points.tobytes() == ((np.array(free, dtype=float).reshape(-1, 3) + 0.5) * cell_m).tobytes()
