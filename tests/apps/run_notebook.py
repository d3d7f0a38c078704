"""Runs the code of a notebook, cell by cell, as a kernel would. python3 run_notebook.py FILE.ipynb"""
import json
import sys

import matplotlib

matplotlib.use("Agg")
with open(sys.argv[1], encoding="utf-8") as file:
    cells = json.load(file)["cells"]
names = {}
code = [cell for cell in cells if cell["cell_type"] == "code"]
for number, cell in enumerate(code):
    if cell["outputs"] or cell["execution_count"] is not None:
        sys.exit(f"cell {number} keeps outputs, expected a notebook without")
    exec(compile("".join(cell["source"]), f"cell {number}", "exec"), names)
print("cells:", len(code))
