#!/usr/bin/python3
"""What VTK's own reader sees in the series of a run, as JSON. Exit 77 where VTK is absent. usage: read_shapes.py RUN"""
import json
import os
import sys
import xml.etree.ElementTree as xml

try:
    import numpy
    from vtkmodules.util.numpy_support import vtk_to_numpy
    from vtkmodules.vtkIOXML import vtkXMLUnstructuredGridReader
except ImportError:
    sys.exit(77)

run = sys.argv[1]
out = []
for data_set in xml.parse(os.path.join(run, "shape.pvd")).getroot().iter("DataSet"):
    reader = vtkXMLUnstructuredGridReader()
    reader.SetFileName(os.path.join(run, data_set.get("file")))
    reader.Update()
    if reader.GetErrorCode() != 0:
        sys.exit(f"{data_set.get('file')}: error {reader.GetErrorCode()}")
    grid = reader.GetOutput()
    moved = vtk_to_numpy(grid.GetPointData().GetVectors("displacement")).astype(float)
    node = vtk_to_numpy(grid.GetPointData().GetArray("node"))
    points = vtk_to_numpy(grid.GetPoints().GetData()).astype(float)
    out.append({
        "t": float(data_set.get("timestep")),
        "time_value": grid.GetFieldData().GetArray("TimeValue").GetValue(0),
        "tip": list(grid.GetFieldData().GetArray("tip").GetTuple(0)),
        "types": sorted({grid.GetCellType(i) for i in range(grid.GetNumberOfCells())}),
        "cells": grid.GetNumberOfCells(),
        "node": node.tolist(),
        "rest": (points - moved).round(7).tolist(),
        "moved": moved.tolist(),
        "largest": float(numpy.sqrt((moved ** 2).sum(axis=1)).max()),
    })
print(json.dumps(out))
