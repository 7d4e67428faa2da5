"""Right-hand sides of compiled modules as functions of JAX, by the foreign function interface of
XLA: they can be jitted, mapped by vmap and differentiated. Needs the extra `jax`, on a processor.
"""

from __future__ import annotations

import ctypes
import hashlib
import tempfile
from collections.abc import Callable
from functools import lru_cache
from importlib.resources import files
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np

from rodgen.errors import InputError, check_type, install_command
from rodgen.loading.generated_module import structure_of
from rodgen.native.library import load_library
from rodgen.scene import Scene
from rodgen.system import System

try:
    import jax
    import jax.numpy as jnp
    from jax.custom_derivatives import SymbolicZero
except ImportError as error:
    missing = f"rodgen.jax needs more: {install_command('jax')} ({error})"
    raise ImportError(missing, name=error.name) from error

CALLS = "jax_calls"
TARGETS = ("rodgen_jax_rhs", "rodgen_jax_jac", "rodgen_jax_by")
DECLARATIONS = """
int rodgen_jax_add(int64_t key, int64_t states, int64_t width, int64_t timed, size_t rhs,
                   size_t jac, size_t rhs_batch);
void *rodgen_jax_rhs(void *frame);
void *rodgen_jax_jac(void *frame);
void *rodgen_jax_by(void *frame);
"""

Field = Callable[[Any, Any, Any], jax.Array]


def rhs(system: System | Scene | ModuleType) -> Field:
    """The right-hand side f(t, y, p) of a compiled module as a function of JAX.

    Jitted code calls the C function itself; under `jax.vmap` all states go through its
    `rhs_batch` at once. Derivatives by the state are those of the exact Jacobian `jac`, forward and
    reverse; those by parameters and by the time are central differences of order six, right to
    about 1e-11 of the rates where these are smooth over a ten-thousandth of the number. Second
    derivatives are refused. In diffrax it is a vector field: `diffrax.ODETerm(rhs(model))`,
    with the parameters as its `args`.

    Parameters
    ----------
    system
        A System or a scene; or a module that `rodgen.build(scene, "c")` made, or one that `rodgen
        derive --target c` wrote with the parts rhs, batch and jac.

    Returns
    -------
    Callable
        f(t, y, p): time t [s], state y (states,) in the order of `model.STATE`, parameters p as
        `model.parameters` packs them; the rates (states,).

    Raises
    ------
    TypeError
        For what is no System, scene or module.
    InputError
        For a module without C functions, for what are no real numbers, while JAX has no doubles
        (it has them after `jax.config.update("jax_enable_x64", True)`), and for other shapes.
    BuildError
        Where no C compiler is found.
    """
    check_type("system", system, System, Scene, ModuleType, see="Scene.from_toml")
    model = system if isinstance(system, ModuleType) else System.of(system).model("c")
    key, states, width = _register(model)

    def ffi_function(name: str, *shape: int) -> Field:
        result = jax.ShapeDtypeStruct((states, *shape), np.float64)
        called = jax.ffi.ffi_call(name, result, vmap_method="expand_dims")
        return lambda t, y, p: called(t, y, p, model=np.int64(key))

    rates, jacobian, others = (
        ffi_function(name, *shape)
        for name, shape in zip(TARGETS, ((), (states,), (1 + width,)), strict=True)
    )
    field = jax.custom_jvp(rates)

    def jvp(primals: Any, tangents: Any) -> tuple[jax.Array, jax.Array]:
        by_t, by_y, by_p = tangents
        moved = jnp.zeros(states)
        if not isinstance(by_y, SymbolicZero):
            moved += jacobian(*primals) @ by_y
        if not (isinstance(by_t, SymbolicZero) and isinstance(by_p, SymbolicZero)):
            matrix = others(*primals)
            if not isinstance(by_t, SymbolicZero):
                moved += matrix[:, 0] * by_t
            if not isinstance(by_p, SymbolicZero):
                moved += matrix[:, 1:] @ by_p
        return field(*primals), moved

    field.defjvp(jvp, symbolic_zeros=True)

    def f(t: Any, y: Any, p: Any) -> jax.Array:
        if not jax.config.jax_enable_x64:
            allowed = 'doubles: jax.config.update("jax_enable_x64", True) at the start'
            raise InputError("y", "numbers of 32 bits", allowed)
        given = [_to_doubles(name, one) for name, one in zip("typ", (t, y, p), strict=True)]
        for name, one, shape in zip("typ", given, ((), (states,), (width,)), strict=True):
            if one.shape != shape:
                raise InputError(name, one.shape, f"of shape {shape} (jax.vmap maps over others)")
        made: jax.Array = field(*given)
        return made

    return f


def _to_doubles(name: str, given: Any) -> jax.Array:
    try:
        made = jnp.asarray(given)
        if not jnp.iscomplexobj(made):
            return made.astype(np.float64)
    except (TypeError, ValueError):
        pass
    raise InputError(name, given, "real numbers, in an array")


# Modules whose functions compiled programs of JAX may call, for as long as the process lives.
_models: dict[int, ModuleType] = {}


def _register(model: ModuleType) -> tuple[int, int, int]:
    """Register a module for calls by XLA; returns its key and its numbers of states and parameters.
    Raises InputError."""
    if not hasattr(getattr(model, "rhs", None), "compiled"):
        raise InputError("model", model.__name__, 'a module that is built for target "c"')
    structure = structure_of(model)
    states, width = len(model.STATE), structure.width
    made_of = f"{model.__name__} {structure.hash} {model.PROVENANCE['template_hash']}"
    key = int.from_bytes(hashlib.sha256(made_of.encode()).digest()[:8], "big", signed=True)
    if key not in _models:
        functions = (model.rhs, model.jac, model.rhs_batch)
        addresses = (function.compiled.address for function in functions)
        timed = bool(structure.expressions or structure.states or structure.masses)
        if not _compile_calls().rodgen_jax_add(key, states, width, timed, *addresses):
            raise InputError("model", model.__name__, "one of at most 4096 in a process")
        _models[key] = model
    return key, states, width


@lru_cache(maxsize=1)
def _compile_calls() -> Any:
    """Compile the library of XLA calls with the header of the installed XLA, and register them."""
    header = Path(jax.ffi.include_dir(), "xla", "ffi", "api", "c_api.h")
    with tempfile.TemporaryDirectory(prefix="rodgen-") as folder:
        place = Path(folder)
        (place / "xla_ffi.h").write_bytes(header.read_bytes())
        text = files("rodgen.native").joinpath(f"{CALLS}.c").read_bytes()
        (place / f"{CALLS}.c").write_bytes(text)
        ffi, library = load_library(CALLS, place, DECLARATIONS, (f"{CALLS}.c", "xla_ffi.h"))
    for name in TARGETS:
        address = int(ffi.cast("uintptr_t", getattr(library, name)))
        capsule = jax.ffi.pycapsule(ctypes.c_void_p(address))
        jax.ffi.register_ffi_target(name, capsule, platform="cpu")
    return library
