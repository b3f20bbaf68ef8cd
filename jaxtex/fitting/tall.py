"""A linear solver for least squares with very many rows and few columns."""

from typing import Any

import equinox as eqx
import jax
import jax.numpy as jnp
import lineax as lx
from jax import Array
from jax.flatten_util import ravel_pytree
from jax.scipy.linalg import cho_solve


class TallCholesky(lx.AbstractLinearSolver):
    """Least squares through the normal equations, the columns made one by one and never transposed.

    A mask fit has tens of thousands of rows and a dozen columns: an orthogonal factorisation costs many times what
    making the matrix costs. Squaring the condition is harmless where columns are scaled alike and damped, as in
    :mod:`jaxtex.fitting.solve`. The unknown must be one flat array.
    """

    def init(self, operator: lx.AbstractLinearOperator, options: dict[str, Any]) -> tuple[Array, Array]:
        del options
        structure = operator.in_structure()
        units = jnp.eye(structure.size, dtype=structure.dtype)
        # One row per pixel keeps a pixel's derivatives together, which vectorises; the barrier keeps the product below
        # from being fused with their making, which would make them many times over.
        matrix = jax.vmap(lambda unit: ravel_pytree(operator.mv(unit))[0], out_axes=-1)(units)
        matrix = jax.lax.optimization_barrier(matrix)
        return matrix, jnp.linalg.cholesky(matrix.T @ matrix)

    def compute(
        self, state: tuple[Array, Array], vector: Any, options: dict[str, Any]
    ) -> tuple[Array, lx.RESULTS, dict[str, Any]]:
        del options
        matrix, factor = state
        return cho_solve((factor, True), ravel_pytree(vector)[0] @ matrix), lx.RESULTS.successful, {}

    def transpose(self, state: Any, options: dict[str, Any]) -> Any:
        raise ValueError("TallCholesky solves no wide systems")

    def conj(self, state: Any, options: dict[str, Any]) -> Any:
        return jax.tree.map(jnp.conj, state, is_leaf=eqx.is_array), options

    def assume_full_rank(self) -> bool:
        return True
