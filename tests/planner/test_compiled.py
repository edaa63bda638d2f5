"""numba's private option `_nrt`, by which kernels do without its runtime for reference-counted objects."""

import numpy as np
import pytest
from numba import njit
from numba.core.errors import NumbaError
from numpy.typing import NDArray

from planner.compiled import inlined, lean


def test_numba_knows_the_option_nrt() -> None:
    """If this fails, numba has renamed or removed the option: leave it out of `planner.compiled`. Plans
    stay the same, and are found about three times as slowly.
    """
    with pytest.raises(KeyError, match="_no_such_option"):
        njit(_no_such_option=False)(lambda: 0)()
    assert njit(_nrt=False)(lambda: 0)() == 0


def test_a_lean_function_reads_and_writes_arrays_and_calls_inlined_ones() -> None:
    @inlined
    def double(value: float) -> float:
        return 2 * value

    @lean
    def scale(values: NDArray[np.float64]) -> float:
        for n in range(len(values)):
            values[n] = double(values[n])
        return values[0]

    values = np.array([1.0, 2.0])
    assert scale(values) == 2.0
    assert values.tolist() == [2.0, 4.0]


def test_a_lean_function_cannot_make_an_array() -> None:
    @lean
    def make() -> NDArray[np.float64]:
        return np.zeros(3)

    with pytest.raises(NumbaError):
        make()
