"""Stores of studies: Zarr arrays in which a block of points is a chunk, written whole, then marked.

The mark of a block is its chunk of `status`, which is written last; a block that lacks a chunk is
not done. Zarr writes every chunk whole or not at all, and leaves out none.
"""

from __future__ import annotations

import json
import math
import os
import re
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numpy as np
from numpy.typing import NDArray

from rodgen.dataset_result import register_accessor
from rodgen.errors import InputError
from rodgen.loading.cache import PACKAGES, source_hash
from rodgen.scene.plain_tables import read_toml
from rodgen.studies.kept_quantities import variables
from rodgen.studies.point_arrays import StudyVariable
from rodgen.studies.sampling import CHUNKS, MARK, Layout, Point

if TYPE_CHECKING:
    import xarray as xr
    import zarr

    from rodgen.studies.study import Study

FORMAT = "2"
NUMBERED = re.compile(r"[0-9]{1,18}")
LARGE = 2 * 10**7  # bytes beyond which a store is read as it is asked for
# What the numbers of a point follow from, to the bit.
SOURCES = (*PACKAGES, "rodgen.integrate", "rodgen.analyse", "rodgen.studies")


def identity() -> dict[str, str]:
    """Return the version of rodgen and a hash of its sources: equal for equal results."""
    return {"rodgen": version("rodgen"), "sources": source_hash(*SOURCES)[:32]}


@dataclass(frozen=True)
class StudyStore:
    """An existing store of a study. layout: its blocks; arrays: by name, the mark last; token: of
    this store alone."""

    path: Path
    study: Study
    layout: Layout
    arrays: dict[str, zarr.Array[Any]]
    token: str

    @classmethod
    def create(cls, path: Path, study: Study, size: int, adaptive: str = "") -> StudyStore:
        """Create a store in blocks of about so many points, or open the one that another client has
        made meanwhile. adaptive: how its points are chosen, where not all are computed. Raises
        InputError where it cannot be written."""
        layout = Layout.of(study.shape, size)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            with tempfile.TemporaryDirectory(
                ".part", f".{path.name}.", path.parent, ignore_cleanup_errors=True
            ) as folder:
                made = Path(folder, path.name)
                try:
                    _create(made, study, layout, adaptive)
                    os.rename(made, path)
                except OSError:
                    if not path.is_dir():
                        raise
        except OSError as error:
            allowed = f"a place for a store ({error.strerror or error})"
            raise InputError("out", str(path), allowed) from None
        return cls.of(path, study, adaptive)

    @classmethod
    def of(cls, path: Path, study: Study, adaptive: str | None = None) -> StudyStore:
        """Open the store at a path, extended to the points of the study where it has fewer;
        adaptive: how its points must have been chosen, None: in any way. Raises InputError for that
        of another study or version; nothing is changed then."""
        group = open_group(path)
        _check_same(path, dict(group.attrs), study, adaptive)
        arrays = {name: open_array(group, name) for name in _array_names(study)}
        mark = arrays[MARK]
        if mark.shape != study.shape:
            if study.count < mark.shape[0]:
                allowed = f"at least {mark.shape[0]}, which the store {path} has"
                raise InputError("sample.count", study.count, allowed)
            _extend(path, arrays, study.count, mark.shape[0])
            group = open_group(path)
            arrays = {name: open_array(group, name) for name in arrays}
        return cls(path, study, Layout(study.shape, mark.chunks), arrays, str(group.attrs["token"]))

    def is_done(self, block: int) -> bool:
        """Whether a block is marked and whole."""
        return self._is_whole(self.layout.position(block))

    def _is_whole(self, place: tuple[int, ...]) -> bool:
        """Whether all chunks of the block at a place exist."""
        return all(chunk.exists() for chunk in self._chunks(place))

    def _chunks(self, place: tuple[int, ...]) -> Iterator[Path]:
        """Yield the files of the block at a place, the mark first."""
        for name, array in reversed(self.arrays.items()):
            inner = "0" * (array.ndim - len(place))
            yield self.path.joinpath(name, CHUNKS, *map(str, place), *inner)

    def drop_damaged_blocks(self) -> None:
        """Remove blocks with a damaged chunk, so that they are computed again. Raises InputError
        where they cannot be removed."""
        from rodgen.studies.integrity import damage_error, is_intact

        for block in self.done_blocks().nonzero()[0]:
            chunks = [*self._chunks(self.layout.position(int(block)))]
            if not all(is_intact(chunk) for chunk in chunks):
                for chunk in chunks:
                    try:
                        chunk.unlink(missing_ok=True)
                    except OSError:  # a folder, say
                        raise damage_error(self.path, f"{chunk.relative_to(self.path)}") from None

    def done_blocks(self) -> NDArray[np.bool_]:
        """Return which blocks are marked and whole, (blocks,)."""
        marked = np.zeros(self.layout.grid, dtype=bool)
        root, depth = self.path / MARK / CHUNKS, marked.ndim
        for folder, _, files in os.walk(root):
            outer = Path(folder).relative_to(root).parts
            if len(outer) == depth - 1:
                for name in filter(NUMBERED.fullmatch, files):
                    place = tuple(map(int, (*outer, name)))
                    if all(at < n for at, n in zip(place, marked.shape, strict=True)):
                        marked[place] = self._is_whole(place)
        return marked.ravel()

    def write_block(
        self, block: int, points: Sequence[Point], arrays: Mapping[str, NDArray[Any]]
    ) -> None:
        """Write the results of the points of a block, then mark it."""
        box = self.layout.slices(block)
        shape = tuple(s.stop - s.start for s in box)
        for name, array in self.arrays.items():
            if name in arrays:
                values = np.asarray(arrays[name])
            else:  # a varied key of a sample
                values = np.array([point[name] for point in points])
            array[box] = values.reshape(shape + values.shape[1:]).astype(array.dtype, copy=False)

    def write_points(self, indices: Sequence[int], arrays: Mapping[str, NDArray[Any]]) -> None:
        """Write single points of a grid into their blocks; nobody else may write meanwhile."""
        numbers = np.asarray(indices)
        at = np.unravel_index(numbers, self.layout.shape)
        places = [i // size for i, size in zip(at, self.layout.chunk, strict=True)]
        blocks = np.ravel_multi_index(places, self.layout.grid)
        for block in np.unique(blocks).tolist():
            box, chosen = self.layout.slices(block), np.flatnonzero(blocks == block)
            inside = tuple(i[chosen] - s.start for i, s in zip(at, box, strict=True))
            for name, array in self.arrays.items():
                values = np.asarray(array[box])
                values[inside] = np.asarray(arrays[name])[chosen].astype(values.dtype)
                array[box] = values

    def read_points(self, indices: Sequence[int]) -> dict[str, NDArray[Any]]:
        """Return the values of some points of a grid, by the names of the variables."""
        at = np.unravel_index(np.asarray(indices), self.layout.shape)
        return {name: np.asarray(array[...])[at] for name, array in self.arrays.items()}


def read_store(path: str | Path) -> xr.Dataset:
    """Read a store: a variable of every kept quantity, with status, message, energy_error and
    seconds of every point, over the varied keys of a grid or the points of a sample.

    Points that are not computed yet have the status "". A store beyond 20 MB is read lazily. Raises
    InputError for what is no store of a study.
    """
    import xarray as xr

    from rodgen.studies.integrity import OWN, SUMS

    register_accessor()
    path = Path(path)
    group = open_group(path)
    data = xr.open_zarr(group.store, consolidated=False, chunks=None)
    for name in (SUMS, OWN):
        data.attrs.pop(name, None)
    drawn = data.attrs.get("coordinates", "").split()
    # In the order in which they were drawn, which xarray does not keep.
    inputs = {name: data[name].variable for name in drawn}
    data = data[json.loads(data.attrs["variables"])].assign_coords(inputs)
    return _plain_text(data.load()) if data.nbytes <= LARGE else data


def _plain_text(data: xr.Dataset) -> xr.Dataset:
    """Convert NumPy's text of any length to types that other libraries know."""
    found = {name: array for name, array in data.variables.items() if array.dtype.kind == "T"}
    return data.assign(
        {name: array.astype("U8" if name == MARK else object) for name, array in found.items()}
    )


def open_group(path: Path) -> zarr.Group:
    """Open the group of the store of a study. Raises InputError where there is none, or it is
    damaged."""
    import zarr

    from rodgen.studies.integrity import DESCRIPTION, ChecksumStore, damage_error

    if path.is_file():
        if path.suffix == ".toml":
            read_toml(path, "store")  # which says of a scene or a study that it is one
        raise InputError("store", str(path), "the store of a study, a folder (this is a file)")
    try:
        store = ChecksumStore(path)
        group = zarr.open_group(store, mode="r+", zarr_format=3)
        if "digest" not in group.attrs:
            raise InputError("store", str(path), "the store of a study")
        names = json.loads(str(group.attrs["variables"]))
        store.blocked = {*names, *str(group.attrs.get("coordinates", "")).split()}
        store.dims = open_array(group, MARK).ndim
        return group
    except InputError:
        raise
    except (OSError, ValueError, KeyError, TypeError) as error:
        if not isinstance(error, OSError) and (path / DESCRIPTION).exists():
            raise damage_error(path, DESCRIPTION) from None
        why = error.strerror if isinstance(error, OSError) and error.strerror else "there is none"
        raise InputError("store", str(path), f"the store of a study ({why})") from None


def open_array(group: zarr.Group, name: str) -> zarr.Array[Any]:
    """Open an array of the group of a store."""
    import zarr

    # A chunk that is not there was lost, not left out.
    with zarr.config.set({"array.write_empty_chunks": True}):
        found = group[name]
    assert isinstance(found, zarr.Array)
    return found


def dtype_of(name: str) -> Any:
    """Return the type of an array: text has any length, as Zarr has no standard for a fixed one."""
    return np.dtypes.StringDType() if name.startswith("U") else np.dtype(name)


def _create(folder: Path, study: Study, layout: Layout, adaptive: str) -> None:
    """Create an empty store."""
    import xarray as xr
    import zarr

    from rodgen.studies.integrity import CODECS, write_checksums

    sampled = study.sample is not None
    along = {} if sampled else {a.name: (a.name, np.array(a.values)) for a in study.axes}
    coordinates = xr.Dataset(coords={k: (d, _object_text(v)) for k, (d, v) in along.items()})
    coded = {str(name): {"compressors": CODECS} for name in coordinates.variables}
    coordinates.to_zarr(folder, mode="w", zarr_format=3, consolidated=False, encoding=coded)
    group = zarr.open_group(folder, mode="r+", zarr_format=3)
    for one in _store_variables(study):
        group.create_array(
            one.name,
            shape=layout.shape + one.shape,
            chunks=layout.chunk + tuple(max(1, n) for n in one.shape),
            dtype=dtype_of(one.dtype),
            fill_value=one.fill,
            compressors=CODECS,
            dimension_names=(*study.dims, *one.dims),
            attributes=one.attributes,
        )
    kept = json.dumps([one.name for one in variables(study)])
    named = {"name": study.name, "digest": study.digest, "format": FORMAT, "variables": kept}
    named["token"] = uuid4().hex  # which no other store has
    group.attrs.update({**named, **study.contents, "adaptive": adaptive, **identity()})
    if sampled:
        group.attrs["coordinates"] = " ".join(one.name for one in study.axes)
    write_checksums(folder)


def _store_variables(study: Study) -> list[StudyVariable]:
    """Return the variables of a store: of a sample, also those of the varied keys."""
    drawn, fills = [], {"i": ("i8", 0), "U": ("U200", "")}
    for axis in study.axes if study.sample is not None else ():
        kind = np.array(axis.value_at(0.0)).dtype.kind
        dtype, fill = fills.get(kind, ("f8", math.nan))
        drawn.append(StudyVariable(axis.name, dtype=dtype, fill=fill))
    return [*drawn, *variables(study)]


def _object_text(values: NDArray[Any]) -> NDArray[Any]:
    return values.astype(object) if values.dtype.kind == "U" else values


def _check_same(
    path: Path, attributes: Mapping[str, Any], study: Study, adaptive: str | None
) -> None:
    """Raise InputError for the store of another study or version."""
    parts = dict(study.contents) | ({} if adaptive is None else {"adaptive": adaptive})
    other = [name for name, text in parts.items() if attributes.get(name) != text]
    if other:
        allowed = f"a store of this study (another: {', '.join(other)})"
        raise InputError("store", str(path), allowed)
    for name, value in {"format": FORMAT, **identity()}.items():
        if attributes.get(name) != value:
            found = attributes.get(name)
            allowed = f"a store that this version of rodgen made ({name} {found}, not {value})"
            raise InputError("store", str(path), allowed)


def _array_names(study: Study) -> list[str]:
    """Return the names of the arrays that blocks are written to, the mark last."""
    return [*(one.name for one in _store_variables(study) if one.name != MARK), MARK]


def _extend(path: Path, arrays: Mapping[str, zarr.Array[Any]], count: int, before: int) -> None:
    """Make room for more points. A last block that was not full is computed again, with the same
    results."""
    import zarr

    from rodgen.studies.integrity import write_checksums

    (chunk,) = arrays[MARK].chunks
    if before % chunk:
        path.joinpath(MARK, CHUNKS, str(before // chunk)).unlink(missing_ok=True)

    def resize(folder: Path) -> None:
        group = zarr.open_group(folder, mode="r+", zarr_format=3)
        for name in arrays:
            array = open_array(group, name)
            array.resize((count, *array.shape[1:]))

    write_checksums(path, resize)
