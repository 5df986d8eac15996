"""Arrays without reference counts, for kernels that pass them on in every step.

At every call numba atomically counts the references to every array of every tuple, which costs
more than the step of a particle. The arrays of a simulation exist for as long as the call into
the kernels lasts, so no counting is needed inside it.
"""

from __future__ import annotations

from numba.core import cgutils
from numba.extending import intrinsic

from abradem.dem.cache import kernel
from abradem.dem.state import State


@intrinsic
def borrowed(typing_context, array):
    """Return ``array`` as a view without reference counting."""

    def codegen(context, builder, signature, arguments):
        view = context.make_array(signature.args[0])(context, builder, arguments[0])
        view.meminfo = cgutils.get_null_value(view.meminfo.type)
        view.parent = cgutils.get_null_value(view.parent.type)
        return view._getvalue()

    return array(array), codegen


@kernel(inline=True)
def borrowed_state(state):
    """Return the state with all its arrays borrowed."""
    return State(
        borrowed(state.tally),
        borrowed(state.particles),
        borrowed(state.pairs),
        borrowed(state.facet_wear),
    )
