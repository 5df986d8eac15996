"""Arrays without reference counts, for kernels that pass them on in every step.

At every call numba atomically counts the references to every array of every tuple, which costs
more than the step of a particle. The arrays of a simulation exist for as long as the call into
the kernels lasts, so no counting is needed inside it.
"""

from __future__ import annotations

from numba.core import cgutils, types
from numba.extending import intrinsic, overload

from abradem.dem.cache import kernel
from abradem.dem.mesh import Mesh
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


def borrowed_mesh(mesh):
    """Return the mesh with all its arrays borrowed; None for the plate. For kernels alone."""
    raise NotImplementedError


@overload(borrowed_mesh)
def _borrowed_mesh(mesh):
    if isinstance(mesh, types.NoneType):
        return lambda mesh: None

    def with_arrays(mesh):
        return Mesh(
            borrowed(mesh.frames),
            borrowed(mesh.reach),
            borrowed(mesh.normals),
            borrowed(mesh.sides),
            borrowed(mesh.side_edge),
            borrowed(mesh.edge_first),
            borrowed(mesh.edge_sides),
            borrowed(mesh.corner_vertex),
            borrowed(mesh.vertex_first),
            borrowed(mesh.vertex_edges),
            borrowed(mesh.cell_first),
            borrowed(mesh.cell_triangles),
            borrowed(mesh.cell_steps),
            borrowed(mesh.part),
            borrowed(mesh.velocity),
            borrowed(mesh.frame_of),
            borrowed(mesh.sums),
            borrowed(mesh.hits),
            borrowed(mesh.walls),
            borrowed(mesh.open_walls),
            borrowed(mesh.spots),
        )

    return with_arrays


@kernel(inline=True)
def borrowed_state(state):
    """Return the state with all its arrays borrowed."""
    return State(
        borrowed(state.tally),
        borrowed(state.particles),
        borrowed(state.pairs),
        borrowed(state.facet_wear),
        borrowed_mesh(state.mesh),
    )
