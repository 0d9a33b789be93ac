"""Parachute canopies and cloth as mass-spring networks, integrated the way a finite-element code would.

The engine of the program ``canopy-fem``. Units are SI; nodes, edges and triangles count from 0, as in the mesh.

=================================  ===================================================================
`Case`                             a case: a file or a dictionary, with other values
`run`, `load`, `Result`            a whole run with the files of ``canopy-fem solve``; its tables
`static`                           the equilibrium of a case, and the modes about it
`Simulation`                       a scene in motion: step by step, with forces and changes from outside
`Network`                          masses and springs from arrays
`rollout`, `Batch`                 many runs at once, on a pool of threads
`check`, `tradeoff`, `sweep`, …    studies
`coupling`, `kratos`, `precice`    couplings with flow solvers
`embedded`, `embedded_coupling`    thin surfaces in a flow of Kratos
`mesh`                             generators, files, meshio, pyvista
`CaseError`, `Diverged`, …         exceptions
=================================  ===================================================================
"""

# The name that type checkers know, without the time that importing `typing` takes.
TYPE_CHECKING = False

if TYPE_CHECKING:
    from .public import *  # noqa: F403
else:

    def __getattr__(name):
        """All public names at once, so that the program, which needs none, starts without numpy."""
        from importlib import import_module, util

        # A module of the package, which `from . import` asks for so while it is being imported.
        if util.find_spec(f"{__name__}.{name}"):
            return import_module(f".{name}", __name__)
        public = import_module(".public", __name__)
        try:
            value = globals()[name] = getattr(public, name)
        except AttributeError:
            raise AttributeError(f"module {__name__!r} has no attribute {name!r}") from None
        return value

    def __dir__():
        return sorted({*globals(), *__getattr__("__all__")})
