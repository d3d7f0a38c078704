#!/usr/bin/python3
"""What VTK's own reader sees in .vtu files, as JSON. Exit 77 where VTK is absent. usage: read_vtk.py FILE.vtu..."""
import json
import sys

try:
    from vtkmodules.vtkFiltersCore import vtkConnectivityFilter, vtkThreshold
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
except ImportError:
    sys.exit(77)


def arrays(data):
    found = {}
    for i in range(data.GetNumberOfArrays()):
        texts = data.GetAbstractArray(i)
        if data.GetArray(i) is None:
            words = [texts.GetValue(k) for k in range(texts.GetNumberOfValues())]
            found[texts.GetName()] = {"size": len(words), "words": sorted(set(words))}
            continue
        values = vtk_to_numpy(data.GetArray(i))
        found[data.GetArrayName(i)] = {
            "size": len(values),
            "min": float(values.min()) if values.size else None,
            "max": float(values.max()) if values.size else None,
        }
    return found


def parts_of_label(grid, label):
    """The number of parts of the cells of one label that are connected over points."""
    threshold = vtkThreshold()
    threshold.SetInputData(grid)
    threshold.SetInputArrayToProcess(0, 0, 0, 1, "label")
    threshold.SetLowerThreshold(label)
    threshold.SetUpperThreshold(label)
    connectivity = vtkConnectivityFilter()
    connectivity.SetInputConnection(threshold.GetOutputPort())
    connectivity.SetExtractionModeToAllRegions()
    connectivity.Update()
    return connectivity.GetNumberOfExtractedRegions()


def named_otherwise(data):
    """Cells whose label_name is not the name of their label."""
    numbers, texts = data.GetArray("label"), data.GetAbstractArray("label_name")
    if numbers is None or texts is None:
        return None
    names = ["safe", "sparse", "gap", "blank"]
    return sum(texts.GetValue(i) != names[int(numbers.GetValue(i))] for i in range(numbers.GetNumberOfTuples()))


out = []
for name in sys.argv[1:]:
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(name)
    reader.Update()
    if reader.GetErrorCode() != 0:
        sys.exit(f"{name}: error {reader.GetErrorCode()}")
    grid = reader.GetOutput()
    volume = {}
    labels = grid.GetCellData().GetArray("label")
    for i in range(grid.GetNumberOfCells() if labels else 0):
        b = grid.GetCell(i).GetBounds()
        key = str(int(labels.GetValue(i)))
        volume[key] = volume.get(key, 0) + (b[1] - b[0]) * (b[3] - b[2]) * (b[5] - b[4])
    out.append({
        "cells": grid.GetNumberOfCells(),
        "points": grid.GetNumberOfPoints(),
        "types": sorted({grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}),
        "bounds": grid.GetBounds(),
        "volume": volume,
        "parts": [parts_of_label(grid, k) for k in range(4)] if labels else None,
        "named_otherwise": named_otherwise(grid.GetCellData()),
        "cell_data": arrays(grid.GetCellData()),
        "point_data": arrays(grid.GetPointData()),
    })


def without_nan(value):
    """JSON has no word for NaN."""
    if isinstance(value, dict):
        return {key: without_nan(v) for key, v in value.items()}
    if isinstance(value, list):
        return [without_nan(v) for v in value]
    return None if isinstance(value, float) and value != value else value


print(json.dumps(without_nan(out)))
