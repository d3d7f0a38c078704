#!/usr/bin/env python3
"""How large the project is: lines, lines of code, files, public types, rooms, arrows. Usage: tests/size.py [COMMIT...]

Without a commit the working tree is counted. Left out of `product`: tests, benches and examples. A public type is a
class, struct or enum that a header declares outside another one. Rooms and arrows are those of tests/house/rooms.txt.
"""
import re
import subprocess
import sys

SOURCE = re.compile(r"\.(cpp|hpp|py|js|css|html|cmake|in|toml|txt|sh)$")


def git(*words):
    return subprocess.run(["git", *words], capture_output=True, check=True).stdout.decode(errors="replace")


def files_of(commit):
    """Path and text of each source file."""
    if not commit:
        for path in git("ls-files", "--cached", "--others", "--exclude-standard").splitlines():
            if SOURCE.search(path):
                try:
                    yield path, open(path, errors="replace").read()
                except FileNotFoundError:
                    pass
        return
    for path in git("ls-tree", "-r", "--name-only", commit).splitlines():
        if SOURCE.search(path):
            yield path, git("show", f"{commit}:{path}")


def is_code(line):
    return bool(line.strip()) and not re.match(r"\s*(//|#(?!include|define|pragma|if|endif|else))", line)


def count(commit):
    parts = {name: [0, 0, 0] for name in ("product", "tests", "benches and examples")}  # files, lines, lines of code
    types, rooms, arrows = 0, 0, 0
    for path, text in files_of(commit):
        name = ("tests" if path.startswith("tests/") else
                "benches and examples" if re.match(r"apps/(bench|examples|paper|peers)/", path) else "product")
        lines = text.splitlines()
        for i, more in enumerate((1, len(lines), sum(map(is_code, lines)))):
            parts[name][i] += more
        if path.endswith(".hpp") and name == "product":
            types += sum(bool(re.match(r"(template <.*> )?(class|struct|enum class|enum) \w+( final)?( : [^{;]*)?\s*\{", l))
                         for l in lines)
        if path == "tests/house/rooms.txt":
            table = [l.split(":")[1].split() for l in lines if re.match(r"[a-z]+(/\w+)? +:", l)]
            rooms, arrows = len(table), sum(map(len, table))
    for name, (files, lines, code) in parts.items():
        print(f"{name:<22} {files:>5} files {lines:>7} lines {code:>7} of code")
    print(f"{types} public types, {rooms} rooms, {arrows} arrows")


for chosen in sys.argv[1:] or [""]:
    print(chosen or "working tree")
    count(chosen)
