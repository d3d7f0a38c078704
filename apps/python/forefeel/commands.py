"""The commands of forefeel in this process."""

from __future__ import annotations

import json
import os
import pathlib
import sys
import tempfile
from collections.abc import Iterable
from typing import Any

from . import _core
from .files import read_table
from .states import frame_of


def command(*words: Any) -> tuple[str, int]:
    """Runs `forefeel WORDS` in this process, where parts registered from Python are known. Returns what it printed
    on stdout and its exit code; bad input raises InputError."""
    sys.stdout.flush()
    with tempfile.TemporaryFile() as printed:
        kept = os.dup(1)
        try:
            os.dup2(printed.fileno(), 1)
            code = _core._command([str(word) for word in words])
        finally:
            os.dup2(kept, 1)
            os.close(kept)
        printed.seek(0)
        return printed.read().decode(), code


def study(file: Any, folder: Any, set: Iterable[str] = ()) -> dict[str, Any]:
    """Runs a study (TOML) into a folder; a rerun resumes. Returns a dict: `cells`, a pandas DataFrame of cells.csv
    (a structured array where pandas is not installed); the sentences `verdict` and
    `advice`; `rankings`, `contrasts` and the other keys of `forefeel study --json`.
    Policies and predictors added with register_policy(name, factory), register_predictor are known to it. Ctrl-C raises KeyboardInterrupt; what is
    finished stays in the folder."""
    flags = [word for override in set for word in ("--set", override)]
    text, code = command("study", file, "-o", folder, "--json", "--quiet", *flags)
    result = json.loads(text) if text else {}
    if code != 0:
        if result.get("interrupted"):
            raise KeyboardInterrupt(f"{file}: interrupted; a rerun resumes")
        raise RuntimeError(f"{file}: the study ended with exit code {code}")
    result["cells"] = frame_of(read_table(pathlib.Path(folder) / "cells.csv"))
    return result
