"""Readers of the files that the command writes."""

from __future__ import annotations

import base64
import csv
import json
import pathlib
import re
import tomllib
import xml.etree.ElementTree
from typing import Any

import numpy as np
from numpy.typing import NDArray

from . import _core
from .states import read_states


def read(file: Any) -> Any:
    """Reads any file that the command writes, by its ending:

    .states                  States
    .csv                     dict of arrays by column: states, points, frames, cells, tables of forefeel-bench
    .inputs                  read_inputs(): all that came into a run
    .json .toml              what JSON and TOML give: summaries, records of a study's cells; scenes
    .msh .mesh .vtk          dict: nodes (v, 3) [m], tets (t, 4), groups of nodes
    .vtu                     dict: points, cells, types, point_data, cell_data
    .pvd                     list of (time, file)
    a folder with frames.csv, or cells.csv   read_run(), read_study()
    another folder (of classify --calibrate, forefeel-bench)   dict of its .csv and .json files by name

    Pictures and pages (.svg .png .pdf .html) are for people, and are not read.
    """
    path = pathlib.Path(file)
    if path.is_dir():
        if (path / "frames.csv").exists():
            return read_run(path)
        if (path / "cells.csv").exists():
            return read_study(path)
        found = {file.name: read(file) for file in sorted(path.iterdir()) if file.suffix in (".csv", ".json")}
        if not found:
            raise _core.InputError(f"{path}: expected a folder with frames.csv (a run), cells.csv (a study), or other "
                                   ".csv and .json files")
        return found
    readers = {".states": read_states, ".csv": read_table, ".json": _read_json, ".toml": _read_toml,
               ".inputs": read_inputs, ".msh": _core.read_mesh, ".mesh": _core.read_mesh, ".vtk": _core.read_mesh,
               ".vtu": read_vtu, ".pvd": read_pvd}
    if path.suffix not in readers:
        raise _core.InputError(f"{path}: has the ending '{path.suffix}', expected {', '.join(readers)}")
    if not path.exists():
        raise _core.InputError(f"{path}: cannot be read: No such file or directory")
    return readers[path.suffix](path)


def read_table(file: Any) -> dict[str, NDArray[Any]]:
    """A CSV file with a header line, such as frames.csv or cells.csv: dict of arrays by column. A column is float
    where all its cells are numbers or empty (nan), else text."""
    with open(file, newline="", encoding="utf-8") as stream:
        rows = csv.reader(line for line in stream if not line.startswith("#"))
        header = next(rows, None)
        if header is None:
            raise _core.InputError(f"{file}: is empty, expected a header line")
        cells = list(rows)
    for line, row in enumerate(cells, start=2):
        if len(row) != len(header):
            raise _core.InputError(f"{file}: line {line}: {len(row)} columns, expected {len(header)}")
    table = {}
    for i, name in enumerate(header):
        column = [row[i] for row in cells]
        try:
            table[name] = np.array([float(cell) if cell else np.nan for cell in column])
        except ValueError:
            table[name] = np.array(column)
    return table


def _read_json(file: Any) -> Any:
    try:
        return json.loads(pathlib.Path(file).read_text(encoding="utf-8"))
    except ValueError as error:
        raise _core.InputError(f"{file}: is not JSON: {error}") from None


def _read_toml(file: Any) -> dict[str, Any]:
    try:
        return tomllib.loads(pathlib.Path(file).read_text(encoding="utf-8"))
    except ValueError as error:
        raise _core.InputError(f"{file}: is not TOML: {error}") from None


def read_inputs(file: Any) -> dict[str, Any]:
    """RUN/session.inputs, all that came into a run (`forefeel replay` renders it again). A dict:

    frames   structured array (n,), one row a frame of the loop: frame (its number), known (number of known states),
             model (serial number of the model that came, 0: none), ended, held (the device's position was not finite,
             the last one was kept), started and now (wall clock [s]), beat (last step of the planner [s]), at (3,) [m],
             rendered (3,) and sent (3,) [N]
    states   structured array with state_dtype: the states in the order in which they became known
    failed   the same, of solves that failed or were set aside
    models   structured array (k,): hip (3,) [m], states (number known then), serial, published
    whole    False: the run was cut; what it wrote until then is here
    made_by, clock ("real" or "virtual"), frame_seconds [s], frames_planned, spacing [m], box (2, 3) [m]
    """
    return _core.read_inputs(str(file))


def read_run(folder: Any) -> dict[str, Any]:
    """The files of a run's folder: dict with frames, dispatches and switches (tables), summary (dict), and states
    (States) where the run kept them."""
    folder = pathlib.Path(folder)
    run: dict[str, Any] = {name: read_table(folder / file) for name, file in
                           (("frames", "frames.csv"), ("dispatches", "dispatch.csv"), ("switches", "switches.csv"))}
    run["summary"] = _read_json(folder / "summary.json")
    if (folder / "session.states").exists():
        run["states"] = read_states(folder / "session.states")
    return run


def read_study(folder: Any) -> dict[str, Any]:
    """The files of a study's folder: dict with cells (a table), and the content of each .json file under its name."""
    folder = pathlib.Path(folder)
    return {"cells": read_table(folder / "cells.csv"),
            **{file.stem: _read_json(file) for file in sorted(folder.glob("*.json"))}}


def read_pvd(file: Any) -> list[tuple[float, pathlib.Path]]:
    """The times [s] and files of a series (.pvd)."""
    path = pathlib.Path(file)
    entries = xml.etree.ElementTree.parse(path).getroot().iter("DataSet")
    return [(float(entry.get("timestep", "nan")), path.parent / entry.get("file", "")) for entry in entries]


_types = {"Float64": "<f8", "Float32": "<f4", "Int64": "<i8", "Int32": "<i4", "UInt32": "<u4", "UInt8": "<u1",
          "Int8": "<i1", "UInt64": "<u8"}


def read_vtu(file: Any) -> dict[str, Any]:
    """A VTK file that the command wrote (.vtu): dict with points (p, 3) [m], cells (c, corners), types uint8 (c,), and
    dicts of arrays point_data and cell_data: numbers, or texts such as label_name. Cells of unequal size: a list of
    arrays."""
    data = pathlib.Path(file).read_bytes()
    found = re.search(rb'<AppendedData encoding="raw">\s*_', data)
    end = data.rfind(b"</AppendedData>")
    head = data if not found else data[:found.end() - 1] + data[end:]
    try:
        root = xml.etree.ElementTree.fromstring(head)
    except xml.etree.ElementTree.ParseError as error:
        raise _core.InputError(f"{file}: is not a VTK file: {error}") from None
    piece = root.find("UnstructuredGrid/Piece")
    if piece is None:
        raise _core.InputError(f"{file}: holds no unstructured grid")
    size_type = np.dtype("<u8" if root.get("header_type") == "UInt64" else "<u4")

    def array(entry: xml.etree.ElementTree.Element) -> NDArray[Any]:
        texts = entry.get("type") == "String"  # each ends with a zero byte
        kind = np.dtype(_types["UInt8" if texts else entry.get("type", "")])
        width = int(entry.get("NumberOfComponents", "1"))
        if entry.get("format") == "appended" and found:
            at = found.end() + int(entry.get("offset", "0"))
            size = int(np.frombuffer(data, size_type, 1, at)[0])
            values = np.frombuffer(data, kind, size // kind.itemsize, at + size_type.itemsize)
        elif entry.get("format") == "binary":
            values = np.frombuffer(base64.b64decode(entry.text or ""), kind, offset=size_type.itemsize)
        else:
            values = np.array((entry.text or "").split(), kind)
        if texts:
            return np.array(values.tobytes().decode().split("\0")[:-1])
        return values.reshape(-1, width) if width > 1 else values

    def named(section: str) -> dict[str, NDArray[Any]]:
        return {entry.get("Name", ""): array(entry) for entry in piece.findall(f"{section}/DataArray")}

    cells = named("Cells")
    corners = np.diff(np.concatenate([[0], cells["offsets"]]))
    even = len(corners) > 0 and np.all(corners == corners[0])
    points = piece.find("Points/DataArray")
    assert points is not None
    return {"points": array(points), "types": cells["types"], "point_data": named("PointData"),
            "cells": cells["connectivity"].reshape(-1, corners[0]) if even
            else np.split(cells["connectivity"], cells["offsets"][:-1]), "cell_data": named("CellData")}
