"""Branches in NetCDF files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from rodgen.dataset_result import register_accessor
from rodgen.errors import InputError
from rodgen.integrate.files import atomic_write

if TYPE_CHECKING:
    import xarray


def save(data: xarray.Dataset, path: Path) -> None:
    """Write a branch to a NetCDF file, whole or not at all."""
    with atomic_write(path) as part:
        data.to_netcdf(part, engine="scipy")


def read(path: Path, field: str, kind: str, *forms: str) -> xarray.Dataset:
    """Read a branch from a NetCDF file. field: name of the argument; kind: of branch, in words;
    forms: allowed values of its attribute `format`. Raises InputError for any other file."""
    import xarray

    register_accessor()
    try:
        with xarray.open_dataset(path, engine="scipy") as file:
            data = file.load()
    except (OSError, ValueError, TypeError, KeyError) as error:
        reason = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(field, str(path), f"a NetCDF file that can be read ({reason})") from None
    if data.attrs.get("format") not in forms:
        allowed = " or ".join(map(repr, forms))
        raise InputError(field, str(path), f"{kind} written by rodgen (format {allowed})")
    return data
