"""Readers of the files that the command writes."""

import csv
import json
import pathlib

import numpy as np


def read_table(file):
    """A CSV file with a header line, such as frames.csv or cells.csv: dict of arrays by column. A column is float
    where all its cells are numbers or empty (nan), else text."""
    with open(file, newline="", encoding="utf-8") as stream:
        rows = csv.reader(stream)
        header = next(rows, None)
        if header is None:
            raise ValueError(f"{file}: is empty, expected a header line")
        cells = list(rows)
    for line, row in enumerate(cells, start=2):
        if len(row) != len(header):
            raise ValueError(f"{file}: line {line}: {len(row)} columns, expected {len(header)}")
    table = {}
    for i, name in enumerate(header):
        column = [row[i] for row in cells]
        try:
            table[name] = np.array([float(cell) if cell else np.nan for cell in column])
        except ValueError:
            table[name] = np.array(column)
    return table


def read_run(folder):
    """The files of a run's folder: dict with frames, dispatches and switches (tables) and summary (dict)."""
    folder = pathlib.Path(folder)
    run = {name: read_table(folder / file) for name, file in
           (("frames", "frames.csv"), ("dispatches", "dispatch.csv"), ("switches", "switches.csv"))}
    run["summary"] = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    return run
